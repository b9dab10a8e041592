// Drawing surfels by WebGL 2. First what is nearest at each pixel: its depth, its normal, which surfel, its colour.
// Then splats: every pixel takes the mean of the surfels around the place that it shows, by Gaussian weights (object
// space, as Ren, Pfister and Zwicker 2002), of those alone that face about the same way and are of the same sheet: a
// quarter of their radius off it, along the mean of both normals, which on a ball is 0, they hardly count.

const WIDTH = 2048; // of textures by surfel
const COMMON = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
uniform mat4 uView;      // world to eye
uniform vec4 uLens;      // 1 / tan at the sides, 1 / tan above, near, far
uniform float uPixel;    // half a pixel at distance 1
uniform float uReach;    // of what is drawn of a disk, in radii
uniform float uGrown;    // disks, where fewer of them stand for all
vec3 unfold(vec2 o) {    // an octahedral normal
  vec3 n = vec3(o, 1.0 - abs(o.x) - abs(o.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
  return normalize(n);
}
vec4 seen(vec3 eye) {
  float n = uLens.z, f = uLens.w;
  return vec4(eye.xy * uLens.xy, (-eye.z * (f + n) - 2.0 * f * n) / (f - n), -eye.z);
}`;
const DISK_VERTEX = `${COMMON}
layout(location = 0) in vec4 aPlace;
layout(location = 1) in vec2 aNormal;
flat out int vIndex;
flat out vec4 vPlace;    // in the eye's frame, and the radius
flat out vec3 vNormal;
out vec3 vEye;
void main() {
  vec3 n = unfold(aNormal), c = (uView * vec4(aPlace.xyz, 1.0)).xyz;
  vNormal = mat3(uView) * n;
  float r = max(uGrown * aPlace.w, 1.4 * uPixel * -c.z);
  vIndex = gl_InstanceID;
  vPlace = vec4(c, r);
  vec3 u = normalize(cross(vNormal, abs(vNormal.x) < 0.6 ? vec3(1, 0, 0) : vec3(0, 1, 0)));
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  vEye = c + uReach * r * (corner.x * u + corner.y * cross(vNormal, u));
  gl_Position = dot(vNormal, c) < 0.0 ? seen(vEye) : vec4(2, 2, 2, 1);  // from behind nothing is seen
}`;
const DISK_FRAGMENT = `${COMMON}
flat in int vIndex;
flat in vec4 vPlace;
flat in vec3 vNormal;
in vec3 vEye;
uniform sampler2D uColor;
layout(location = 0) out vec4 oPlace;
layout(location = 1) out vec4 oColor;
void main() {
  float d = length(vEye - vPlace.xyz) / vPlace.w;
  if (d > 1.0) discard;
  // A shallow cone in place of the disk: of disks that overlap, each is seen where it is the nearest.
  vec4 at = seen(vEye - 0.4 * vPlace.w * d * vNormal);
  gl_FragDepth = 0.5 + 0.5 * at.z / at.w;
  oPlace = vec4(-vEye.z, vNormal.xy, float(vIndex) + 1.0);
  oColor = texelFetch(uColor, ivec2(vIndex % ${WIDTH}, vIndex / ${WIDTH}), 0);
}`;
const TRIANGLE_VERTEX = `${COMMON}
layout(location = 0) in vec3 aCorner;
layout(location = 1) in uint aOwner;
flat out int vIndex;
out vec3 vEye;
void main() {
  vIndex = int(aOwner);
  vEye = (uView * vec4(aCorner, 1.0)).xyz;
  gl_Position = seen(vEye);
}`;
const TRIANGLE_FRAGMENT = `${COMMON}
flat in int vIndex;
in vec3 vEye;
uniform sampler2D uColor;
layout(location = 0) out vec4 oPlace;
layout(location = 1) out vec4 oColor;
void main() {
  oPlace = vec4(-vEye.z, normalize(cross(dFdx(vEye), dFdy(vEye))).xy, float(vIndex) + 1.0);
  oColor = texelFetch(uColor, ivec2(vIndex % ${WIDTH}, vIndex / ${WIDTH}), 0);
}`;
const SPLAT_FRAGMENT = `${COMMON}
flat in int vIndex;
flat in vec4 vPlace;
flat in vec3 vNormal;
in vec3 vEye;
uniform sampler2D uColor, uPlaces;
uniform float uSurfels;
out vec4 oSum;
void main() {
  vec4 first = texelFetch(uPlaces, ivec2(gl_FragCoord.xy), 0);
  if (first.w == 0.0 || first.w > uSurfels) discard;  // nothing, or a lamp
  vec3 at = vEye * (first.x / -vEye.z);  // what the pixel shows
  vec3 n = vec3(first.yz, sqrt(max(0.0, 1.0 - dot(first.yz, first.yz))));
  vec3 away = (at - vPlace.xyz) / vPlace.w;
  float d = dot(away, away);
  if (d > uReach * uReach || dot(n, vNormal) < 0.5) discard;
  float off = 4.0 * dot(away, normalize(n + vNormal));
  float w = exp(-2.0 * (d + off * off * off * off));
  oSum = vec4(w * texelFetch(uColor, ivec2(vIndex % ${WIDTH}, vIndex / ${WIDTH}), 0).rgb, w);
}`;
const SCREEN_VERTEX = `#version 300 es
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }`;
const SCREEN_FRAGMENT = `${COMMON}
uniform sampler2D uPlaces, uColors, uSums;
uniform int uFiner;      // pixels of the pictures across one of the screen
uniform float uExposure; // 0: colours are for the screen as they are
uniform bool uSmooth;
uniform float uMarked;   // this surfel has a colour of its own
out vec4 oColor;
vec3 srgb(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}
vec4 shade(ivec2 p) {  // and whether there is anything
  float index = texelFetch(uPlaces, p, 0).w;
  if (index == 0.0) return vec4(0.0);
  vec3 c = texelFetch(uColors, p, 0).rgb;
  vec4 blended = texelFetch(uSums, p, 0);
  if (uSmooth && blended.a > 1e-3) c = blended.rgb / blended.a;
  if (uExposure > 0.0) c = srgb(uExposure * c);
  return vec4(index == uMarked ? vec3(0.9, 0.0, 0.35) : c, 1.0);
}
void main() {
  vec3 sum = vec3(0.0);
  for (int y = 0; y < uFiner; ++y) for (int x = 0; x < uFiner; ++x) {
    ivec2 p = uFiner * ivec2(gl_FragCoord.xy) + ivec2(x, y);
    vec4 c = shade(p);
    // Where the edges of patches meet in the middle of another's, single pixels stay open.
    for (int k = 0; k < 2 && c.a == 0.0; ++k) {
      ivec2 aside = ivec2(1 - k, k);
      vec4 one = shade(p - aside), other = shade(p + aside);
      if (one.a * other.a > 0.0) c = 0.5 * (one + other);
    }
    sum += c.a == 0.0 ? vec3(1.0) : c.rgb;
  }
  oColor = vec4(sum / float(uFiner * uFiner), 1.0);
}`;

function makeDrawing(canvas, scene) {
  const gl = canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true });
  if (!gl) throw new Error("This page needs WebGL 2, which this browser does not have or has switched off.");
  if (!gl.getExtension("EXT_color_buffer_float"))
    throw new Error("This page needs pictures of floats, which this browser's WebGL lacks.");

  function program(vertex, fragment) {
    const made = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
    const at = {};
    for (let k = gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS) - 1; k >= 0; --k) {
      const name = gl.getActiveUniform(made, k).name;
      at[name] = gl.getUniformLocation(made, name);
    }
    return { made, at };
  }
  function array(attributes) {
    const made = gl.createVertexArray();
    gl.bindVertexArray(made);
    attributes.forEach(([data, size, type, normalized, each], k) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(k);
      if (type === gl.UNSIGNED_INT) gl.vertexAttribIPointer(k, size, type, 0, 0);
      else gl.vertexAttribPointer(k, size, type, normalized, 0, 0);
      gl.vertexAttribDivisor(k, each);
    });
    return made;
  }
  function texture(unit, format, width, height, layout, type, data) {
    const made = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, made);
    gl.texImage2D(gl.TEXTURE_2D, 0, format, width, height, 0, layout, type, data);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return made;
  }

  const disk = program(DISK_VERTEX, DISK_FRAGMENT), triangle = program(TRIANGLE_VERTEX, TRIANGLE_FRAGMENT);
  const splat = program(DISK_VERTEX, SPLAT_FRAGMENT), screen = program(SCREEN_VERTEX, SCREEN_FRAGMENT);
  const disks = array([[scene.places, 4, gl.FLOAT, false, 1], [scene.normals, 2, gl.SHORT, true, 1]]);
  const owners = new Uint32Array(3 * scene.owners.length).map((_, k) => scene.owners[(k / 3) | 0]);
  const corners = array([[scene.corners, 3, gl.FLOAT, false, 0], [owners, 1, gl.UNSIGNED_INT, false, 0]]);
  const nothing = gl.createVertexArray();
  const rows = Math.ceil(scene.count / WIDTH);
  // Light that turns with its environment: the texture of what was looked at last.
  const turning = scene.turning && makeTurning(scene), turned = turning && new Float32Array(3 * WIDTH * rows);
  const turnedTexture = turning && texture(0, gl.RGB32F, WIDTH, rows, gl.RGB, gl.FLOAT, turned);
  let turnedAs = "";
  function turn(color, degrees) {
    const { name, white } = scene.colors[color], as = `${name} ${degrees}`;
    if (as === turnedAs) return;
    turnedAs = as;
    turning.fill(name, degrees, white, turned);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, WIDTH, rows, gl.RGB, gl.FLOAT, turned);
  }
  const colors = scene.colors.map(({ kind, data, turns }) => {
    if (turns) return turnedTexture;
    const padded = new Uint32Array(WIDTH * rows);
    padded.set(data);
    return kind === "light"
      ? texture(0, gl.RGB9_E5, WIDTH, rows, gl.RGB, gl.UNSIGNED_INT_5_9_9_9_REV, padded)
      : texture(0, gl.RGBA8, WIDTH, rows, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(padded.buffer));
  });
  let size = [0, 0], made = [];
  const targets = {};
  function resize(width, height) {
    if (size[0] === width && size[1] === height) return;
    size = [width, height];
    made.forEach((old) => (old instanceof WebGLTexture ? gl.deleteTexture(old) : gl.deleteRenderbuffer(old)));
    targets.first ||= gl.createFramebuffer();
    targets.sums ||= gl.createFramebuffer();
    const places = texture(1, gl.RGBA32F, width, height, gl.RGBA, gl.FLOAT, null);
    const shown = texture(2, gl.RGBA16F, width, height, gl.RGBA, gl.HALF_FLOAT, null);
    const sums = texture(3, gl.RGBA16F, width, height, gl.RGBA, gl.HALF_FLOAT, null);
    const depth = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.first);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, places, 0);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT1, gl.TEXTURE_2D, shown, 0);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.sums);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, sums, 0);
    made = [places, shown, sums, depth];
  }
  function use({ made: what, at }, view, lens, reach, grown = 1) {
    gl.useProgram(what);
    gl.uniformMatrix4fv(at.uView, false, view);
    gl.uniform4fv(at.uLens, lens);
    gl.uniform1f(at.uPixel, 1 / (lens[1] * size[1]));
    gl.uniform1f(at.uReach, reach);
    gl.uniform1f(at.uGrown, grown);
    ["uColor", "uPlaces", "uColors", "uSums"].forEach((name, unit) => at[name] && gl.uniform1i(at[name], unit));
  }

  return {
    turning,
    // view: world to eye, by columns; lens: [1 / tan at the sides, 1 / tan above, near, far].
    draw(view, lens, look, finer) {
      const width = canvas.width, height = canvas.height;
      resize(finer * width, finer * height);
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, colors[look.color]);
      if (scene.colors[look.color].turns) turn(look.color, look.turn);
      gl.bindFramebuffer(gl.FRAMEBUFFER, targets.first);
      gl.viewport(0, 0, ...size);
      gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
      gl.clearBufferfv(gl.COLOR, 1, [0, 0, 0, 0]);
      gl.clearBufferfv(gl.DEPTH, 0, [1]);
      gl.enable(gl.DEPTH_TEST);
      const few = Math.ceil(look.part * scene.disks);  // they stand in no order
      use(disk, view, lens, 1, few ? Math.sqrt(scene.disks / few) : 1);
      gl.bindVertexArray(disks);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, few);
      gl.enable(gl.CULL_FACE);
      use(triangle, view, lens, 1);
      gl.bindVertexArray(corners);
      gl.drawArrays(gl.TRIANGLES, 0, owners.length);
      gl.disable(gl.CULL_FACE);
      gl.disable(gl.DEPTH_TEST);
      gl.bindFramebuffer(gl.FRAMEBUFFER, targets.sums);
      gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
      if (look.smooth) {
        gl.enable(gl.BLEND);
        gl.blendFunc(gl.ONE, gl.ONE);
        use(splat, view, lens, 1.5);
        gl.uniform1f(splat.at.uSurfels, scene.surfels);
        gl.bindVertexArray(disks);
        gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, scene.surfels);
        gl.disable(gl.BLEND);
      }
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      gl.viewport(0, 0, width, height);
      use(screen, view, lens, 1);
      gl.uniform1i(screen.at.uFiner, finer);
      gl.uniform1f(screen.at.uExposure, scene.colors[look.color].kind === "light" ? look.exposure : 0);
      gl.uniform1i(screen.at.uSmooth, look.smooth ? 1 : 0);
      gl.uniform1f(screen.at.uMarked, look.marked + 1);
      gl.bindVertexArray(nothing);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    },
    // The surfel at a place of the canvas, in fractions from the upper left corner; -1 where none is.
    surfelAt(x, y) {
      const pixel = new Float32Array(4);
      gl.bindFramebuffer(gl.FRAMEBUFFER, targets.first);
      gl.readBuffer(gl.COLOR_ATTACHMENT0);
      gl.readPixels(Math.floor(x * size[0]), Math.floor((1 - y) * size[1]), 1, 1, gl.RGBA, gl.FLOAT, pixel);
      return Math.round(pixel[3]) - 1;
    },
  };
}
