// What a page holds, and what mouse, fingers, keys and the panel do. The camera goes around a target.

const find = (id) => document.getElementById(id);
const sub = (a, b) => a.map((v, k) => v - b[k]), add = (a, b, s) => a.map((v, k) => v + s * b[k]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2], unit = (a) => a.map((v) => v / Math.hypot(...a));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

function readScene() {
  const about = JSON.parse(find("about").textContent), text = atob(find("data").textContent.trim());
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < bytes.length; ++k) bytes[k] = text.charCodeAt(k);
  const types = { float32: Float32Array, int16: Int16Array, uint32: Uint32Array };
  const part = ([type, from, count]) => new types[type](bytes.buffer, from, count);
  const colors = about.colors.map(({ data, above, ...color }) =>
    ({ ...color, data: data && part(data), above: above && part(above) }));
  const { irradiance, direct, reflectance, emission, ...others } = about.turning || {};
  const waves = (of) => of && { waves: part(of.waves), scales: part(of.scales) };
  const turning = about.turning && { ...others, irradiance: waves(irradiance), direct: waves(direct),
    reflectance: reflectance && part(reflectance), emission: emission && part(emission) };
  return { ...about, turning, places: part(about.places), normals: part(about.normals), indices: part(about.indices),
    corners: part(about.corners), owners: part(about.owners), colors };
}

function start() {
  const scene = readScene(), canvas = find("view"), drawing = makeDrawing(canvas, scene);
  const vertical = unit(scene.camera.up);
  const across = unit(cross(vertical, Math.abs(vertical[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0]));
  const ahead = cross(vertical, across);
  const look = { color: 0, smooth: true, exposure: 1, turn: 0, marked: -1 };
  let target, distance, azimuth, elevation;

  function home() {
    target = [...scene.camera.target];
    const from = sub(scene.camera.eye, target);
    distance = Math.hypot(...from);
    azimuth = Math.atan2(dot(from, ahead), dot(from, across));
    elevation = Math.asin(Math.max(-1, Math.min(1, dot(from, vertical) / distance)));
  }
  // The way from the target to the eye; to the right, and up in the picture.
  function frame() {
    const flat = add(across.map((v) => v * Math.cos(azimuth)), ahead, Math.sin(azimuth));
    const back = add(flat.map((v) => v * Math.cos(elevation)), vertical, Math.sin(elevation));
    const right = add(across.map((v) => v * -Math.sin(azimuth)), ahead, Math.cos(azimuth));
    return [right, cross(back, right), back];
  }
  // In steps: 0 while something moves where that takes long, with disks for splats, and with larger ones for many; 1 as
  // asked; 2 finer and averaged, once all stands still.
  let waiting = 0, later = 0, drawn = 0, slow = false, part = 1;
  function draw(step) {
    waiting = 0;
    clearTimeout(later);
    const dense = Math.min(window.devicePixelRatio || 1, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((v) => Math.max(1, Math.round(v * dense)));
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const [right, up, back] = frame(), eye = add(target, back, distance);
    const view = [0, 1, 2].flatMap((k) => [right[k], up[k], back[k], 0]);
    view.push(-dot(right, eye), -dot(up, eye), -dot(back, eye), 1);
    const tall = 1 / Math.tan((scene.camera.fov * Math.PI) / 360);
    // In a picture higher than wide the field of view is that of its width.
    const lens = width < height ? [tall, (tall * width) / height] : [(tall * height) / width, tall];
    const far = Math.hypot(...sub(eye, scene.center)) + scene.extent;
    const near = Math.max(far - 2 * scene.extent, 1e-3 * Math.min(distance, scene.extent));
    const began = performance.now();
    const now = { ...look, smooth: look.smooth && step > 0, part: step ? 1 : part };
    drawing.draw(view, [...lens, near, far], now, step === 2 ? 2 : 1);
    if (step < 2) {
      drawing.surfelAt(0.5, 0.5); // waits for the picture
      const took = performance.now() - began;
      if (step) slow = drawn++ > 0 && took > 150; // the first one compiles
      else if (took > 100) part = Math.max(part / 2, 1 / 32, Math.min(1, 5000 / scene.disks));
    }
    const next = step === 0 ? 1 : step === 1 && !slow && 4 * width * height <= 9e6 ? 2 : 0;
    document.body.dataset.still = next ? "" : "yes";
    if (next) later = setTimeout(() => draw(next), 150);
  }
  const redraw = () => {
    document.body.dataset.still = "";
    waiting ||= requestAnimationFrame(() => draw(slow ? 0 : 1));
  };

  const numbers = (values, digits = 6) => Array.from(values, (v) => Number(v.toPrecision(digits))).join("  ");
  function note() {
    const { kind, label, white, unit, turns, low, high, digits, trimmed } = scene.colors[look.color];
    const said = white ? [label, `white is ${(white / look.exposure).toPrecision(3)} ${unit}`.trim()] : [label];
    if (kind === "number") {
      const ends = `purple is ${numbers([low], digits)}, yellow is ${numbers([high], digits)}`;
      said.push(trimmed ? `${ends} (1st to 99th percentile)` : ends);
    }
    if (turns) said.push(`turned by ${Number(look.turn.toPrecision(4))}\u00b0`);
    find("note").textContent = said.join("; ");
    find("exposure").disabled = !white;
  }
  function setColor(k) {
    look.color = find("color").selectedIndex = (k + scene.colors.length) % scene.colors.length;
    note(), redraw();
  }
  function setStyle(smooth) {
    look.smooth = smooth;
    find("style").value = smooth ? "splats" : "disks";
    redraw();
  }
  function setExposure(stops) {
    find("exposure").value = stops;
    look.exposure = 2 ** stops;
    note(), redraw();
  }
  function setTurn(degrees) {
    find("turn").value = look.turn = ((degrees % 360) + 360) % 360;
    note(), tell(), redraw();
  }
  const fixed = (v, decimals) => v.toFixed(decimals).replace(/^-(?=[0.]*$)/, ""); // no -0.000
  // The values of the marked surfel.
  function tell() {
    const k = look.marked;
    find("values").style.display = k < 0 ? "none" : "block";
    if (k < 0) return;
    const [x, y, z, radius] = scene.places.subarray(4 * k, 4 * k + 4);
    // Of a thousandth of the radius, as far as floats from the origin tell.
    const told = Math.max(radius / 1000, Math.max(Math.abs(x), Math.abs(y), Math.abs(z)) * 2 ** -23);
    const decimals = Math.max(0, Math.min(12, -Math.floor(Math.log10(told))));
    const lines = [
      `${k < scene.surfels ? "surfel" : "lamp"} ${scene.indices[k]}`,
      `position     ${[x, y, z].map((v, c) => fixed(v + scene.origin[c], decimals)).join("  ")}`,
      `radius       ${numbers([radius])}`,
    ];
    for (const { kind, name, turns, data, white, sent, low, above, digits } of scene.colors) {
      if (kind === "number" && k < scene.surfels)
        lines.push(`${name.padEnd(12)} ${numbers([low + above[k]], digits + 1)}`);
      if (kind !== "light" || (k >= scene.surfels && !sent)) continue; // what a lamp receives is not known
      const light = turns ? drawing.turning.at(name, k, look.turn) : unpackLight(data[k], white);
      lines.push(`${name.padEnd(12)} ${numbers(light, 3)}`);
    }
    find("values").textContent = lines.join("\n");
  }
  function mark(k) {
    look.marked = k;
    tell(), redraw();
  }
  const turn = (right, up) => {
    azimuth -= right;
    elevation = Math.max(-1.5, Math.min(1.5, elevation + up));
  };
  const closer = (factor) => (distance = Math.max(1e-4 * scene.extent, Math.min(20 * scene.extent, distance * factor)));
  function move(dx, dy) {
    const [right, up] = frame();
    const step = (2 * distance * Math.tan((scene.camera.fov * Math.PI) / 360)) / canvas.clientHeight;
    target = add(add(target, right, -dx * step), up, dy * step);
  }

  const fingers = new Map();
  let travelled = 0;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    travelled = fingers.size === 1 ? 0 : 99;
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId), at = [event.clientX, event.clientY];
    if (!before) return;
    const [dx, dy] = [at[0] - before[0], at[1] - before[1]];
    travelled += Math.hypot(dx, dy);
    if (fingers.size === 2) {
      const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
      const apart = (place) => Math.max(1, Math.hypot(place[0] - other[0], place[1] - other[1]));
      closer(apart(before) / apart(at));
      move(dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons & 6) move(dx, dy);
    else turn((dx * 5) / canvas.clientHeight, (dy * 5) / canvas.clientHeight);
    fingers.set(event.pointerId, at);
    redraw();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (fingers.delete(event.pointerId) && travelled < 4 && event.button === 0)
      mark(drawing.surfelAt(event.offsetX / canvas.clientWidth, event.offsetY / canvas.clientHeight));
  });
  canvas.addEventListener("pointercancel", (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    closer(2 ** (Math.sign(event.deltaY) * Math.min(1, Math.abs(event.deltaY) / 300)));
    redraw();
  }, { passive: false });
  const show = (id) => (find(id).style.display = getComputedStyle(find(id)).display === "none" ? "block" : "none");
  const keys = {
    c: () => setColor(look.color + 1), s: () => setStyle(!look.smooth), h: () => show("keys"), p: () => show("panel"),
    "+": () => setExposure(Math.log2(look.exposure) + 0.5), "-": () => setExposure(Math.log2(look.exposure) - 0.5),
    0: () => (home(), redraw()),
  };
  if (scene.turning) {
    find("turned").hidden = find("turns").hidden = false;
    keys[","] = () => setTurn(look.turn - 5);
    keys["."] = () => setTurn(look.turn + 5);
  }
  window.addEventListener("keydown", (event) => {
    if (!event.ctrlKey && !event.metaKey && !event.altKey && event.target.tagName !== "SELECT") keys[event.key]?.();
  });
  for (const color of scene.colors) find("color").add(new Option(color.name));
  find("color").addEventListener("change", () => setColor(find("color").selectedIndex));
  find("style").addEventListener("change", () => setStyle(find("style").value === "splats"));
  find("exposure").addEventListener("input", () => setExposure(Number(find("exposure").value)));
  find("turn").addEventListener("input", () => {
    const degrees = Number(find("turn").value);
    setTurn(degrees);
    find("turn").value = degrees; // what is dragged to the end stays there
  });
  new ResizeObserver(redraw).observe(canvas);

  // #azimuth=30&elevation=20&color=direct&style=disks&exposure=1&turn=90: degrees beyond the first camera's azimuth,
  // stops, and degrees that the environment is turned by.
  function fromAddress() {
    home();
    const given = new URLSearchParams(location.hash.slice(1));
    const degrees = (name) => (Number(given.get(name)) * Math.PI) / 180;
    azimuth += degrees("azimuth");
    if (given.has("elevation")) elevation = Math.max(-1.5, Math.min(1.5, degrees("elevation")));
    setColor(Math.max(0, scene.colors.findIndex((color) => color.name === given.get("color"))));
    setStyle(given.get("style") !== "disks");
    setExposure(Number(given.get("exposure") || 0));
    if (scene.turning) setTurn(Number(given.get("turn") || 0));
    if (given.has("panel")) find("panel").style.display = given.get("panel") === "0" ? "none" : "block";
  }
  window.addEventListener("hashchange", fromAddress);
  fromAddress();
}

try {
  start();
} catch (error) {
  find("fault").style.display = "block";
  find("fault").textContent = error.message;
}
