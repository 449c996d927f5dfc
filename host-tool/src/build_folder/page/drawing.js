"use strict";
// Draws with WebGL2: the sums of light of a look, exactly, and the stack in three dimensions.

const VERTICES = `#version 300 es
in vec2 corner;
void main() { gl_Position = vec4(corner, 0.0, 1.0); }`;

// The sums as the bits of single-precision numbers. A processor may fuse a product with the sum it goes into, which
// rounds once instead of twice: what passes through `exact` it cannot fuse, because it does not know that `none` is 0.
const SUMS = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler2DArray;
uniform sampler2DArray films;
uniform sampler2D table;
uniform uint none;
uniform int stride;
out uvec4 bits;

vec3 exact(vec3 value) { return uintBitsToFloat(floatBitsToUint(value) ^ none); }

// k / 255 rounded once: k * 257 / 65536 has no rounding at all.
vec3 ink(int column, int row, int film) {
  vec3 code = floor(texelFetch(films, ivec3(column, row, film), 0).rgb * 255.0 + 0.5);
  return code * (257.0 / 65536.0) + exact(code * 5.983839201917363e-8);
}

vec3 along(int column, int row, float part, int film) {
  vec3 upper = ink(column, row, film);
  vec3 lower = ink(column, row + 1, film);
  return part == 1.0 ? lower : upper + exact(part * (lower - upper));
}

void main() {
  ivec2 pixel = stride * ivec2(gl_FragCoord.xy);
  vec3 sum = vec3(0.0);
  for (int film = 0; film < FILMS; film++) {
    vec4 column = texelFetch(table, ivec2(pixel.x, 2 * film), 0);
    vec4 row = texelFetch(table, ivec2(pixel.y, 2 * film + 1), 0);
    if (column.x < 0.0 || row.x < 0.0) continue;
    vec3 left = along(int(column.x), int(row.x), row.y, film);
    vec3 right = along(int(column.x) + 1, int(row.x), row.y, film);
    vec3 light = column.y > 0.5
      ? exact(column.z * left) + exact(column.w * right)
      : column.z * (left + exact(column.w * (right - left)));
    sum += exact(light);
  }
  bits = uvec4(floatBitsToUint(sum), 0u);
}`;

// Each pixel's ray meets each film where it does: the films are planes across it.
const SCENE = `#version 300 es
precision highp float;
precision highp sampler2D;
precision highp sampler2DArray;
uniform sampler2DArray films;
uniform sampler2D weights;
uniform vec2 screen;
uniform vec2 half_size;
uniform float pitch;
uniform float extent;
uniform float gain;
uniform float edges;
uniform bool far;
uniform bool encode;
uniform vec3 eye;
uniform vec3 right;
uniform vec3 above;
out vec4 color;

void main() {
  vec2 place = (2.0 * gl_FragCoord.xy - screen) / min(screen.x, screen.y) * extent;
  vec3 seen = place.x * right + place.y * above;
  vec3 from = far ? seen : eye;
  vec3 ray = far ? -eye : seen - eye;
  float line = 2.5 * extent / min(screen.x, screen.y);
  vec3 light = vec3(0.0);
  float outlines = 0.0;
  for (int film = 0; film < FILMS; film++) {
    float weight = texelFetch(weights, ivec2(film, 0), 0).r;
    if (weight < 0.0) continue;
    float z = (float(FILMS - 1) / 2.0 - float(film)) * pitch;
    float along = (z - from.z) / ray.z;
    if (along <= 0.0 && !far) continue;
    vec2 at = from.xy + along * ray.xy;
    vec2 inside = half_size - abs(at);
    float nearest = min(inside.x, inside.y);
    if (nearest < 0.0) continue;
    outlines += edges * (nearest < line ? 0.16 : 0.012);
    light += weight * textureLod(films, vec3(0.5 + 0.5 * at.x / half_size.x, 0.5 - 0.5 * at.y / half_size.y, float(film)), 0.0).rgb;
  }
  light = clamp(light * gain, 0.0, 1.0);
  vec3 code = mix(1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, light * 12.92, lessThanEqual(light, vec3(0.0031308)));
  color = vec4((encode ? code : light) + outlines * vec3(0.55, 0.65, 1.0), 1.0);
}`;

class Drawing {
  // Throws where the browser cannot draw this stack.
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, preserveDrawingBuffer: true });
    if (!gl) throw new Error("This browser has no WebGL2");
    const size = Math.max(stack.width_px, stack.height_px, 2 * stack.films);
    if (size > gl.getParameter(gl.MAX_TEXTURE_SIZE) || stack.films > gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS)) {
      throw new Error("This stack is too large for this computer's graphics");
    }
    this.gl = gl;
    this.canvas = canvas;
    this.sums = this.program(SUMS);
    this.scene = this.program(SCENE);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, 3, -1, -1, 3]), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    this.films = this.texture(gl.TEXTURE_2D_ARRAY, 0, gl.LINEAR);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.RGBA8, stack.width_px, stack.height_px, stack.films);
    this.table = this.texture(gl.TEXTURE_2D, 1, gl.NEAREST);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, Math.max(stack.width_px, stack.height_px), 2 * stack.films);
    this.weights = this.texture(gl.TEXTURE_2D, 2, gl.NEAREST);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.R32F, stack.films, 1);
    this.target = this.texture(gl.TEXTURE_2D, 3, gl.NEAREST);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32UI, stack.width_px, stack.height_px);
    this.buffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.buffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.target, 0);
  }

  program(fragments) {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [type, source] of [
      [gl.VERTEX_SHADER, VERTICES],
      [gl.FRAGMENT_SHADER, fragments.replaceAll("FILMS", stack.films)],
    ]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "corner");
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error("This browser cannot draw the stack");
    return program;
  }

  texture(kind, unit, filter) {
    const gl = this.gl;
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(kind, texture);
    gl.texParameteri(kind, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(kind, gl.TEXTURE_MAG_FILTER, filter);
    gl.texParameteri(kind, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(kind, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    return texture;
  }

  putFilm(film, image) {
    const gl = this.gl;
    const [width, height] = [stack.width_px, stack.height_px];
    gl.activeTexture(gl.TEXTURE0);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, film, width, height, 1, gl.RGBA, gl.UNSIGNED_BYTE, image);
  }

  set(program, name, kind, ...value) {
    this.gl[`uniform${kind}`](this.gl.getUniformLocation(program, name), ...value);
  }

  // The sums of light of every `stride`th pixel and row: interleaved red, green and blue.
  sumsOf(look, weights, stride) {
    const gl = this.gl;
    const [width, height] = [Math.ceil(stack.width_px / stride), Math.ceil(stack.height_px / stride)];
    gl.useProgram(this.sums);
    gl.activeTexture(gl.TEXTURE1);
    const line = Math.max(stack.width_px, stack.height_px);
    const table = samplingTable(look, weights);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, line, 2 * stack.films, gl.RGBA, gl.FLOAT, table);
    this.set(this.sums, "films", "1i", 0);
    this.set(this.sums, "table", "1i", 1);
    this.set(this.sums, "none", "1ui", 0);
    this.set(this.sums, "stride", "1i", stride);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.buffer);
    gl.viewport(0, 0, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const bits = new Uint32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA_INTEGER, gl.UNSIGNED_INT, bits);
    const values = new Float32Array(bits.buffer);
    const sums = new Float32Array(3 * width * height);
    for (let i = 0, j = 0; i < sums.length; i += 3, j += 4) {
      sums[i] = values[j];
      sums[i + 1] = values[j + 1];
      sums[i + 2] = values[j + 2];
    }
    return { sums, width, height };
  }

  // Draws the stack as the eye of `look` sees it, `apart` times as deep; a negative weight leaves a film out.
  drawScene(look, weights, { gain, apart, edges }) {
    const gl = this.gl;
    const { width, height } = this.canvas;
    const [slopeX, slopeY] = slopeInside(look);
    const length = Math.hypot(slopeX, slopeY, 1);
    const toEye = [slopeX / length, slopeY / length, 1 / length];
    const far = look.ideal || look.distance === null;
    const eye = far ? toEye : toEye.map((part) => part * look.distance);
    // Across the line of sight: level to the right, and upward.
    const flat = Math.hypot(toEye[0], toEye[2]);
    const right = [toEye[2] / flat, 0, -toEye[0] / flat];
    const above = [
      toEye[1] * right[2],
      toEye[2] * right[0] - toEye[0] * right[2],
      -toEye[1] * right[0],
    ];
    const half = [stack.width_px, stack.height_px].map((pixels) => (pixels * stack.pixel_mm) / 2);
    const pitch = stack.pitch_mm * apart;
    gl.useProgram(this.scene);
    gl.activeTexture(gl.TEXTURE2);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, stack.films, 1, gl.RED, gl.FLOAT, Float32Array.from(weights));
    this.set(this.scene, "films", "1i", 0);
    this.set(this.scene, "weights", "1i", 2);
    this.set(this.scene, "screen", "2f", width, height);
    this.set(this.scene, "half_size", "2f", ...half);
    this.set(this.scene, "pitch", "1f", pitch);
    this.set(this.scene, "extent", "1f", this.extent(half, pitch));
    this.set(this.scene, "gain", "1f", gain);
    this.set(this.scene, "edges", "1f", edges ? 1 : 0);
    this.set(this.scene, "far", "1i", far ? 1 : 0);
    this.set(this.scene, "encode", "1i", stack.light ? 1 : 0);
    this.set(this.scene, "eye", "3f", ...eye);
    this.set(this.scene, "right", "3f", ...right);
    this.set(this.scene, "above", "3f", ...above);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // Waits until all is drawn, and tells how long that took: reading a pixel has to wait for it.
  timeToFinish() {
    const gl = this.gl;
    const began = performance.now();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    return performance.now() - began;
  }

  // Half of what the canvas shows across, in mm: the stack's sphere, with a little room.
  extent([halfWidth, halfHeight], pitch) {
    return 1.02 * Math.hypot(halfWidth, halfHeight, ((stack.films - 1) * pitch) / 2);
  }
}
