// WebGL 2: one or two bodies with their buffers, drawn with one program.

import { displaced, plane } from "./replay_data.js";
import { FRAGMENT, VERTEX } from "./shaders.js";

function compiled(gl) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || "the shaders do not link");
  return program;
}

// Area-weighted vertex normals of moved positions; the shader brings them to unit length.
function normalsOf(p, faces, out) {
  out.fill(0);
  for (let i = 0; i < faces.length; i += 3) {
    const a = 3 * faces[i], b = 3 * faces[i + 1], c = 3 * faces[i + 2];
    const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
    const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    for (const corner of [a, b, c]) { out[corner] += x; out[corner + 1] += y; out[corner + 2] += z; }
  }
}

// The part at one frame, in buffers that are made once and then filled anew.
class Body {
  constructor(gl, program, replay) {
    Object.assign(this, { gl, replay, frame: -1, layer: "" });
    this.positions = new Float32Array(replay.positions.length);
    this.normals = new Float32Array(replay.positions.length);
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    const attribute = (name, width, kind, normalised, bytes) => {
      const buffer = gl.createBuffer(), place = gl.getAttribLocation(program, name);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, bytes, gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, width, kind, normalised, 0, 0);
      return buffer;
    };
    const count = replay.vertices;
    this.buffers = {
      position: attribute("position", 3, gl.FLOAT, false, 12 * count), normal: attribute("normal", 3, gl.FLOAT, false, 12 * count),
      colour: attribute("colour", 3, gl.UNSIGNED_BYTE, true, 3 * count), raw: attribute("raw", 1, gl.UNSIGNED_SHORT, false, 2 * count),
    };
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, replay.faces, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
  }

  fill(name, data) {
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, this.buffers[name]);
    this.gl.bufferSubData(this.gl.ARRAY_BUFFER, 0, data);
  }

  show(frame, layer) {
    if (frame !== this.frame) {
      (this.replay.shape ?? displaced)(this.replay, frame, this.positions);
      normalsOf(this.positions, this.replay.faces, this.normals);
      this.fill("position", this.positions);
      this.fill("normal", this.normals);
      if (this.replay.channels.colour) this.fill("colour", plane(this.replay, "colour", frame));
    }
    if (layer !== "style" && (frame !== this.frame || layer !== this.layer)) this.fill("raw", plane(this.replay, layer, frame));
    Object.assign(this, { frame, layer });
  }
}

export class Scene {
  constructor(canvas, replay) {
    const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error("This browser offers no WebGL 2, so the part cannot be turned here.");
    Object.assign(this, { canvas, replay, gl, program: compiled(gl), places: {} });
    this.current = new Body(gl, this.program, replay);
    this.original = null; // made when it is first compared with
    this.rampTexture(replay.colours.ramp);
    this.lamps(replay.light);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.SCISSOR_TEST);
  }

  rampTexture(ramp) {
    const gl = this.gl;
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array(ramp));
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
  }

  lamps(light) {
    this.gl.useProgram(this.program);
    for (const [name, value] of Object.entries(light))
      if (Array.isArray(value)) this.gl.uniform3fv(this.place(name), value);
      else this.gl.uniform1f(this.place(name), value);
  }

  place(name) { return (this.places[name] ??= this.gl.getUniformLocation(this.program, name)); }

  draw(camera, { frame, layer, threshold, compare }) {
    const { gl, canvas } = this, width = canvas.width / (compare ? 2 : 1);
    this.current.show(frame, layer.key);
    const bodies = [this.current];
    if (compare) {
      this.original ??= new Body(gl, this.program, this.replay);
      this.original.show(0, layer.key);
      bodies.unshift(this.original);
    }
    gl.useProgram(this.program);
    this.look(camera.matrices(width / canvas.height));
    this.colour(layer, threshold);
    bodies.forEach((body, side) => {
      gl.viewport(side * width, 0, width, canvas.height);
      gl.scissor(side * width, 0, width, canvas.height);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.bindVertexArray(body.array);
      gl.drawElements(gl.TRIANGLES, this.replay.faces.length, gl.UNSIGNED_INT, 0);
    });
  }

  look({ view, projection, upwards }) {
    this.gl.uniformMatrix4fv(this.place("view"), false, view);
    this.gl.uniformMatrix4fv(this.place("projection"), false, projection);
    this.gl.uniform3fv(this.place("upwards"), upwards);
  }

  colour(layer, threshold) {
    const gl = this.gl, field = this.replay.channels[layer.key] ?? { low: 0, step: 1 };
    const split = threshold !== null, inside = split && (threshold - layer.low) * (layer.high - threshold) > 0;
    gl.uniform1f(this.place("low"), field.low);
    gl.uniform1f(this.place("stride"), field.step);
    gl.uniform1i(this.place("styled"), layer.key === "style" ? 1 : 0);
    gl.uniform1i(this.place("split"), split ? 1 : 0);
    gl.uniform3f(this.place("range"), layer.low, inside ? threshold : layer.high, threshold ?? 0);
    gl.uniform1f(this.place("pixel"), window.devicePixelRatio || 1);
    for (const [name, colour] of Object.entries({ ...this.replay.colours, missing: this.replay.colours.unknown }))
      if (name !== "ramp" && name !== "unknown") gl.uniform3fv(this.place(name), colour.map((part) => part / 255));
  }

  // Browsers allow only a few contexts at a time: give this one back at once, not when garbage is collected.
  dispose() { this.gl.getExtension("WEBGL_lose_context")?.loseContext(); }
}
