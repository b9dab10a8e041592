// Light that turns with its environment: of each surfel nine waves of the angle, int16 times a scale of its own, make
// its irradiance exactly (spherical harmonics of five bands turn by waves of up to four periods).

const WAVES = 9;

function makeTurning(scene) {
  const { irradiance, direct, reflectance, emission, brightest } = scene.turning;
  const emitted = emission && new Float32Array(3 * emission.length);
  emission?.forEach((packed, k) => emitted.set(unpackLight(packed, brightest), 3 * k));

  function wavesAt(degrees) {
    const angle = (degrees * Math.PI) / 180, at = [1];
    for (let k = 1; k < WAVES / 2; ++k) at.push(Math.cos(k * angle), Math.sin(k * angle));
    return at;
  }
  // Irradiance of a surfel, where five bands are below 0 none, into three places of `out`.
  function irradianceOf({ waves, scales }, k, at, out, place) {
    let red = 0, green = 0, blue = 0;
    for (let m = 0, from = 3 * WAVES * k; m < WAVES; ++m, from += 3) {
      red += at[m] * waves[from];
      green += at[m] * waves[from + 1];
      blue += at[m] * waves[from + 2];
    }
    out[place] = Math.max(0, scales[k] * red);
    out[place + 1] = Math.max(0, scales[k] * green);
    out[place + 2] = Math.max(0, scales[k] * blue);
  }
  const other = [0, 0, 0];
  function valueOf(name, k, at, out, place) {
    irradianceOf(name === "direct" ? direct : irradiance, k, at, out, place);
    if (name === "indirect") {
      irradianceOf(direct, k, at, other, 0);
      for (let c = 0; c < 3; ++c) out[place + c] = Math.max(0, out[place + c] - other[c]);
    } else if (name === "radiosity") {
      for (let c = 0; c < 3; ++c) {
        out[place + c] *= reflectance[3 * k + c] / 32767;
        if (emitted) out[place + c] += emitted[3 * k + c];
      }
    }
  }

  return {
    // The light of surfel k, with the environment turned by so many degrees.
    at(name, k, degrees) {
      const out = [0, 0, 0];
      valueOf(name, k, wavesAt(degrees), out, 0);
      return out;
    },
    // That of all surfels, over `white`, into three numbers each.
    fill(name, degrees, white, out) {
      const at = wavesAt(degrees);
      for (let k = 0; k < scene.surfels; ++k) valueOf(name, k, at, out, 3 * k);
      for (let k = 3 * scene.surfels - 1; k >= 0; --k) out[k] /= white;
    },
  };
}

// Three channels of nine bits each with a common exponent, as OpenGL's RGB9_E5.
function unpackLight(packed, scale) {
  const step = 2 ** ((packed >>> 27) - 24) * scale;
  return [packed & 511, (packed >>> 9) & 511, (packed >>> 18) & 511].map((v) => v * step);
}
