"use strict";
// Draws what a viewer of the stack sees: the same sums as `vitrine view`, film by film, on the graphics processor.
(() => {
  const stack = JSON.parse(document.getElementById("stack").textContent);
  const section = document.getElementById("viewer");
  const canvas = section.querySelector("canvas");
  const gl = canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true });
  if (!gl) {
    section.querySelector(".no-webgl").hidden = false;
    section.querySelector(".stage").hidden = true;
    return;
  }
  const control = (name) => section.querySelector(`[name=${name}]`);
  const number = (name) => Number(control(name).value);
  const radians = (degrees) => (degrees * Math.PI) / 180;

  const vertexSource = `#version 300 es
    in vec2 corner;
    void main() { gl_Position = vec4(corner, 0.0, 1.0); }`;
  const fragmentSource = `#version 300 es
    precision highp float;
    precision highp sampler2DArray;
    uniform sampler2DArray films;
    uniform vec4 film[${stack.films}];  // scale, column offset, row offset, weight
    uniform float gain;
    uniform float stride;  // 1 draws every pixel
    uniform bool encode;
    out vec4 color;
    void main() {
      vec2 size = vec2(textureSize(films, 0).xy);
      vec2 middle = (size - 1.0) / 2.0;
      vec2 pixel = vec2(0.0, size.y - 1.0) + stride * vec2(gl_FragCoord.x - 0.5, 0.5 - gl_FragCoord.y);
      vec3 light = vec3(0.0);
      for (int k = 0; k < ${stack.films}; k++) {
        vec2 place = middle + film[k].x * (pixel - middle) + film[k].yz;
        if (any(lessThan(place, vec2(0.0))) || any(greaterThan(place, size - 1.0))) continue;
        vec2 first = floor(place);
        vec2 part = place - first;
        ivec2 a = ivec2(first);
        ivec2 b = min(a + 1, ivec2(size) - 1);
        vec3 upper = mix(texelFetch(films, ivec3(a.x, a.y, k), 0).rgb, texelFetch(films, ivec3(b.x, a.y, k), 0).rgb, part.x);
        vec3 lower = mix(texelFetch(films, ivec3(a.x, b.y, k), 0).rgb, texelFetch(films, ivec3(b.x, b.y, k), 0).rgb, part.x);
        light += film[k].w * mix(upper, lower, part.y);
      }
      light = clamp(light * gain, 0.0, 1.0);
      vec3 code = mix(1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, light * 12.92, lessThanEqual(light, vec3(0.0031308)));
      color = vec4(encode ? code : light, 1.0);
    }`;

  function compile(type, source) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    return shader;
  }

  const program = gl.createProgram();
  gl.attachShader(program, compile(gl.VERTEX_SHADER, vertexSource));
  gl.attachShader(program, compile(gl.FRAGMENT_SHADER, fragmentSource));
  gl.linkProgram(program);
  gl.useProgram(program);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, 3, -1, -1, 3]), gl.STATIC_DRAW);
  gl.enableVertexAttribArray(gl.getAttribLocation(program, "corner"));
  gl.vertexAttribPointer(gl.getAttribLocation(program, "corner"), 2, gl.FLOAT, false, 0, 0);
  const uniform = (name) => gl.getUniformLocation(program, name);

  // The refracted ray's slope, and for each film its place in the picture and its weight.
  function rays() {
    const outside = [Math.tan(radians(number("horizontal"))), Math.tan(radians(number("vertical")))];
    const length = Math.hypot(outside[0], outside[1], 1);
    const sines = outside.map((slope) => slope / length / stack.index);
    const cosine = Math.sqrt(1 - sines[0] ** 2 - sines[1] ** 2);
    const slope = sines.map((sine) => sine / cosine);
    const ideal = control("ideal").checked;
    const far = ideal || control("far").checked;
    const last = stack.films - 1;
    const values = new Float32Array(4 * stack.films);
    let sum = 0;
    for (let k = 0; k <= last; k++) {
      const z = (last / 2 - k) * stack.pitch_mm;
      const scale = far ? 1 : 1 - (z * Math.hypot(slope[0], slope[1], 1)) / number("distance");
      const uv = number("top") * stack.tau_uv ** k + number("bottom") * stack.tau_uv ** (last - k);
      const weight = ideal ? 1 : uv * stack.tau_visible ** (k / cosine);
      values.set([scale, (z * slope[0]) / stack.pixel_mm, -(z * slope[1]) / stack.pixel_mm, weight], 4 * k);
      sum += weight;
    }
    for (let k = 0; k <= last; k++) values[4 * k + 3] /= sum || 1;
    return values;
  }

  function draw(gain, encode, stride) {
    gl.viewport(0, 0, Math.ceil(canvas.width / stride), Math.ceil(canvas.height / stride));
    gl.uniform1f(uniform("gain"), gain);
    gl.uniform1f(uniform("stride"), stride);
    gl.uniform1i(uniform("encode"), encode ? 1 : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // The gain that brings the 99.5th percentile to white, as `vitrine view` takes it, to the eye's precision: one pixel
  // in sixteen tells it.
  function whiteGain() {
    const stride = 4;
    draw(1, false, stride);
    const [width, height] = [Math.ceil(canvas.width / stride), Math.ceil(canvas.height / stride)];
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    const counts = new Uint32Array(256);
    for (let i = 0; i < pixels.length; i += 4) for (let c = 0; c < 3; c++) counts[pixels[i + c]]++;
    let above = 0.005 * 3 * width * height;
    let white = 255;
    while (white > 1 && (above -= counts[white]) > 0) white--;
    return 255 / white;
  }

  function show() {
    gl.uniform4fv(uniform("film"), rays());
    // A page opened with #gain=G draws light as it is, to be compared with `vitrine view --gain G`.
    const asked = Number(new URLSearchParams(location.hash.slice(1)).get("gain"));
    if (asked > 0) draw(asked, false, 1);
    else draw(whiteGain(), stack.light, 1);
    const tilt = control("tilt").checked;
    const turn = `perspective(60rem) rotateY(${-number("horizontal")}deg) rotateX(${-number("vertical")}deg)`;
    canvas.style.transform = tilt ? turn : "none";
    for (const output of section.querySelectorAll("output")) {
      output.value = `${number(output.htmlFor.value)}${output.dataset.unit}`;
    }
    control("distance").disabled = control("far").checked || control("ideal").checked;
    for (const lamp of ["top", "bottom"]) control(lamp).disabled = control("ideal").checked;
    canvas.dataset.drawn = "yes";
  }

  section.addEventListener("input", show);
  for (const button of section.querySelectorAll("button[data-view]")) {
    button.addEventListener("click", () => {
      const view = stack.views[Number(button.dataset.view)];
      for (const name of ["horizontal", "vertical", "top", "bottom"]) control(name).value = view[name];
      control("far").checked = view.distance === null;
      if (view.distance !== null) control("distance").value = view.distance;
      show();
    });
  }
  let held = null;
  canvas.addEventListener("pointerdown", (event) => {
    held = [event.clientX, event.clientY, number("horizontal"), number("vertical")];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held) return;
    control("horizontal").value = held[2] + (event.clientX - held[0]) / 4;
    control("vertical").value = held[3] - (event.clientY - held[1]) / 4;
    show();
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (held = null));

  async function load() {
    canvas.width = stack.width_px;
    canvas.height = stack.height_px;
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, gl.createTexture());
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.RGBA8, stack.width_px, stack.height_px, stack.films);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    for (const [k, film] of stack.pictures.entries()) {
      const image = new Image();
      image.src = `data:image/png;base64,${film}`;
      await image.decode();
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, k, stack.width_px, stack.height_px, 1, gl.RGBA, gl.UNSIGNED_BYTE, image);
    }
    show();
  }
  load();
})();
