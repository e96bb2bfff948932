"use strict";

const NONE = 65535;
const COLOURS = Uint8Array.from(atob(document.getElementById("colours").textContent.trim()), c => c.charCodeAt(0));

/** Return packed numbers: inflate, put the bytes of each number together again, and sum up the differences. */
async function unpacked(text, Type) {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const size = Type.BYTES_PER_ELEMENT, count = planes.length / size, whole = new Uint8Array(planes.length);
  for (let b = 0; b < size; b++) for (let i = 0; i < count; i++) whole[i * size + b] = planes[b * count + i];
  const numbers = new Type(whole.buffer);
  for (let i = 1; i < count; i++) numbers[i] += numbers[i - 1];
  return numbers;
}

const VERTEX = `#version 300 es
in vec3 place; in float value;
uniform mat3 rotation; uniform vec3 centre; uniform vec2 scale, pan; uniform float depth, nearer;
out float share; out vec3 at;
void main() {
  at = rotation * (place - centre);
  share = value;
  gl_Position = vec4(at.xy * scale + pan, -at.z * depth - nearer, 1.0);
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in float share; in vec3 at;
uniform sampler2D colours; uniform vec2 span; uniform vec4 plain; uniform bool lit, contours;
out vec4 colour;
void main() {
  float t = clamp((share - span.x) / (span.y - span.x), 0.0, 1.0);
  vec3 c = plain.a > 0.5 ? plain.rgb : share < -0.001 ? vec3(0.82) : texture(colours, vec2((t * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  float k = t * 10.0, width = max(fwidth(k), 1e-6);
  if (contours && plain.a < 0.5 && t > 0.0 && t < 1.0)
    c = mix(t > 0.55 ? vec3(0.0) : vec3(1.0), c, max(smoothstep(0.4, 1.1, abs(fract(k - 0.5) - 0.5) / width), smoothstep(0.12, 0.3, width)));
  if (lit) c *= 0.5 + 0.5 * abs(normalize(cross(dFdx(at), dFdy(at))).z);
  colour = vec4(c, 1.0);
}`;

/** Return a number in four digits. */
function shown(value) {
  if (!Number.isFinite(value)) return "none";
  return value !== 0 && Math.abs(value) < 1e-3 ? value.toExponential(2) : String(Number(value.toPrecision(4)));
}

/** Return a value of a field; what is nothing beside the largest one, and only round-off, is 0. */
function valueOf(field, share) {
  const value = field.smallest + share * (field.largest - field.smallest);
  return Math.abs(value) < 1e-9 * Math.max(Math.abs(field.smallest), Math.abs(field.largest)) ? 0 : value;
}

class Player {
  constructor(root) {
    this.root = root;
    this.data = JSON.parse(root.querySelector("script").textContent);
    const find = name => root.querySelector(`[data-part="${name}"]`);
    this.part = Object.fromEntries(
      ["stage", "under", "bodies", "over", "stamp", "level", "told", "field", "span", "contours", "names", "play",
        "back", "on", "ramp", "from", "middle", "to", "whole", "reading", "in", "out", "reset"].map(n => [n, find(n)]));
    this.view = {};
    this.cache = new Map();
    this.shape = null;
  }

  async start() {
    const gl = this.part.bodies.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    if (!gl || typeof DecompressionStream === "undefined") {
      this.part.stage.hidden = true;
      this.part.reading.textContent = "This browser draws no WebGL 2; the pictures below show the last level.";
      return;
    }
    this.gl = gl;
    this.program = this.linked();
    this.buffers = new Map();
    this.resetView();
    this.listen();
    await this.show();
  }

  linked() {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "place");
    gl.bindAttribLocation(program, 1, "value");
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || "no program");
    gl.useProgram(program);
    this.at = name => gl.getUniformLocation(program, name);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, COLOURS);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.LINEAR);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    return program;
  }

  resetView() {
    this.view = this.data.solid ? { yaw: -0.45, pitch: -0.95, zoom: 1, x: 0, y: 0 } : { yaw: 0, pitch: 0, zoom: 1, x: 0, y: 0 };
  }

  listen() {
    const { part } = this, redraw = () => this.show();
    part.level.addEventListener("input", () => { this.root.dispatchEvent(new CustomEvent("level", { bubbles: true })); this.show(); });
    for (const control of [part.field, part.span, part.contours, part.names]) control.addEventListener("change", redraw);
    part.back.addEventListener("click", () => this.go(this.level - 1));
    part.on.addEventListener("click", () => this.go(this.level + 1));
    part.play.addEventListener("click", () => this.play());
    part.in.addEventListener("click", () => this.zoom(1.3));
    part.out.addEventListener("click", () => this.zoom(1 / 1.3));
    part.reset.addEventListener("click", () => { this.resetView(); this.draw(); });
    part.stage.addEventListener("keydown", event => this.key(event));
    part.stage.addEventListener("wheel", event => {
      if (!event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      this.zoom(event.deltaY < 0 ? 1.15 : 1 / 1.15);
    }, { passive: false });
    this.listenToPointers();
    new ResizeObserver(() => this.state && this.draw()).observe(part.stage);
  }

  listenToPointers() {
    const stage = this.part.stage, down = new Map();
    stage.addEventListener("pointerdown", event => {
      if (event.target.closest("button")) return;
      down.set(event.pointerId, [event.clientX, event.clientY]);
      stage.setPointerCapture(event.pointerId);
    });
    for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, event => down.delete(event.pointerId));
    stage.addEventListener("pointerleave", () => { this.part.reading.textContent = ""; });
    stage.addEventListener("pointermove", event => {
      const before = down.get(event.pointerId), now = [event.clientX, event.clientY];
      if (!before) return this.read(event);
      const others = [...down].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
      down.set(event.pointerId, now);
      if (others.length) {
        const apart = place => Math.hypot(place[0] - others[0][0], place[1] - others[0][1]);
        return this.zoom(apart(now) / Math.max(apart(before), 1));
      }
      this.drag(now[0] - before[0], now[1] - before[1], event.shiftKey);
    });
  }

  drag(x, y, sideways) {
    if (this.data.solid && !sideways) {
      this.view.yaw += x * 0.008;
      this.view.pitch = Math.max(-Math.PI, Math.min(0, this.view.pitch + y * 0.008));
    } else {
      this.view.x += x;
      this.view.y += y;
    }
    this.draw();
  }

  key(event) {
    const step = 24, moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
    if (event.target !== this.part.stage) return;
    if (moves[event.key]) this.drag(...moves[event.key], event.shiftKey);
    else if (event.key === "+" || event.key === "=") this.zoom(1.3);
    else if (event.key === "-") this.zoom(1 / 1.3);
    else if (event.key === "0") { this.resetView(); this.draw(); }
    else return;
    event.preventDefault();
  }

  zoom(factor) {
    const zoom = Math.max(0.5, Math.min(60, this.view.zoom * factor)), ratio = zoom / this.view.zoom;
    Object.assign(this.view, { zoom, x: this.view.x * ratio, y: this.view.y * ratio });
    this.draw();
  }

  get level() { return Number(this.part.level.value); }

  go(level) {
    this.part.level.value = String(Math.max(0, Math.min(this.data.levels.length - 1, level)));
    this.part.level.dispatchEvent(new Event("input"));
  }

  play() {
    const stop = () => { clearInterval(this.timer); this.timer = 0; this.part.play.textContent = "\u25B6"; this.part.play.setAttribute("aria-label", "play the levels"); };
    if (this.timer) return stop();
    if (this.level === this.data.levels.length - 1) this.go(0);
    this.part.play.textContent = "\u23F8";
    this.part.play.setAttribute("aria-label", "stop playing");
    this.timer = setInterval(() => { this.go(this.level + 1); if (this.level === this.data.levels.length - 1) stop(); }, 700);
  }

  /** Return unpacked numbers, which are kept for the next time. */
  numbers(text, Type) {
    if (!this.cache.has(text)) this.cache.set(text, unpacked(text, Type));
    return this.cache.get(text);
  }

  async places(text) {
    const key = `places ${text}`;
    if (!this.cache.has(key)) {
      const rounded = await this.numbers(text, Uint16Array), [low, high] = this.data.window, count = rounded.length / 3;
      const found = new Float32Array(3 * count);
      for (let a = 0; a < 3; a++) for (let i = 0; i < count; i++)
        found[3 * i + a] = low[a] + rounded[a * count + i] / (NONE - 1) * (high[a] - low[a] || 1);
      this.cache.set(key, found);
    }
    return this.cache.get(key);
  }

  async show() {
    const level = this.data.levels[this.level], field = this.data.fields[this.part.field.selectedIndex];
    const packed = this.data.shapes[level.shape], kinds = { triangles: Uint32Array, lines: Uint32Array, owner: Uint16Array, loops: Int32Array, rigid: Int32Array, walls: Uint32Array };
    const shape = {};
    for (const [name, Type] of Object.entries(kinds)) shape[name] = await this.numbers(packed[name], Type);
    const rounded = await this.numbers(level.values[field.name], Uint16Array);
    const values = Float32Array.from(rounded, number => number === NONE ? -1 : number / (NONE - 1));
    this.state = { level, field, shape, values, places: await this.places(level.places), walls: await this.places(level.wall_places) };
    this.tell();
    this.draw();
  }

  /** Return the ends of the colours, as shares of the range of the field over all levels. */
  span() {
    const { field, values } = this.state, width = field.largest - field.smallest || 1;
    if (this.part.span.value === "level") {
      let low = 1, high = 0;
      for (const value of values) if (value >= 0) { low = Math.min(low, value); high = Math.max(high, value); }
      return low < high ? [low, high] : [low - 1e-3, low + 1e-3];
    }
    const ends = [(field.from - field.smallest) / width, (field.to - field.smallest) / width];
    return ends[0] < ends[1] ? ends : [ends[0] - 1e-3, ends[0] + 1e-3];
  }

  tell() {
    const { part } = this, { level, field } = this.state, count = this.data.levels.length;
    const place = level.plate_displacement ? `plate displacement ${shown(level.plate_displacement)}, ` : "";
    const words = `level ${this.level + 1} of ${count}: ${place}load factor ${shown(level.load_factor)}${level.certified ? "" : " \u2013 NOT CERTIFIED"}`;
    part.told.textContent = words;
    part.level.setAttribute("aria-valuetext", words);
    part.stamp.hidden = level.certified && this.data.certified;
    part.stamp.textContent = level.certified ? "RUN NOT CERTIFIED" : "NOT CERTIFIED";
    part.back.disabled = this.level === 0;
    part.on.disabled = this.level === count - 1;
    part.play.disabled = count === 1;
    const [low, high] = this.span(), value = share => valueOf(field, share);
    part.from.textContent = `${low > 1e-6 ? "\u2264 " : ""}${shown(value(low))}`;
    part.middle.textContent = shown(value((low + high) / 2));
    part.to.textContent = `${high < 1 - 1e-6 ? "\u2265 " : ""}${shown(value(high))}`;
    part.whole.textContent = `${field.title}; from ${shown(value(0))} to ${shown(field.largest)} over all levels`;
    part.stage.setAttribute("aria-label", `Deformed tissue coloured by ${field.title}, ${words}`);
    this.root.dataset.shown = `${this.level} ${field.name}`;
  }

  /** Return the matrix of the view, by rows. */
  rotation() {
    const { yaw, pitch } = this.view, c = Math.cos(yaw), s = Math.sin(yaw), d = Math.cos(pitch), e = Math.sin(pitch);
    return [[c, -s, 0], [d * s, d * c, -e], [e * s, e * c, d]];
  }

  fit() {
    const { stage } = this.part, [low, high] = this.data.window, size = high.map((end, axis) => end - low[axis]);
    const solid = this.data.solid, radius = Math.hypot(...size) / 2 || 1;
    const span = solid ? [1.5 * radius, 1.5 * radius] : [1.06 * size[0] || 1, 1.06 * size[1] || 1];
    const wide = stage.clientWidth, tall = Math.round(Math.min(wide * Math.max(0.45, Math.min(1.1, solid ? 0.75 : span[1] / span[0])), 0.78 * Math.max(innerHeight, 480)));
    stage.style.height = `${tall}px`;
    stage.style.touchAction = solid || this.view.zoom > 1.01 ? "none" : "pan-y";
    const pixels = this.view.zoom * Math.min(wide / span[0], tall / span[1]);
    return { wide, tall, pixels, radius, centre: low.map((end, axis) => (end + high[axis]) / 2) };
  }

  draw() {
    const fit = this.fit(), ratio = Math.min(devicePixelRatio || 1, 3), { part, gl } = this;
    for (const canvas of [part.under, part.bodies, part.over]) {
      if (canvas.width !== Math.round(fit.wide * ratio) || canvas.height !== Math.round(fit.tall * ratio))
        Object.assign(canvas, { width: Math.round(fit.wide * ratio), height: Math.round(fit.tall * ratio) });
    }
    this.rotated = this.rotation();
    this.fitted = fit;
    gl.viewport(0, 0, part.bodies.width, part.bodies.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.uniformMatrix3fv(this.at("rotation"), true, this.rotated.flat());
    gl.uniform3fv(this.at("centre"), fit.centre);
    gl.uniform2f(this.at("scale"), 2 * fit.pixels / fit.wide, 2 * fit.pixels / fit.tall);
    gl.uniform2f(this.at("pan"), 2 * this.view.x / fit.wide, -2 * this.view.y / fit.tall);
    gl.uniform1f(this.at("depth"), 0.45 / fit.radius);
    gl.uniform2fv(this.at("span"), this.span());
    gl.uniform1i(this.at("contours"), Number(part.contours.checked));
    const { field, shape, places, values, walls } = this.state, ofBodies = field.where === "bodies";
    this.drawMesh(gl.TRIANGLES, places, shape.triangles, ofBodies ? values : null, { plain: [0.8, 0.83, 0.86], lit: this.data.solid });
    if (this.data.solid) {
      if (!ofBodies) this.drawMesh(gl.TRIANGLES, walls, shape.walls, values, { lit: true, nearer: 0.0015 });
      this.drawMesh(gl.LINES, places, shape.lines, null, { plain: [0.1, 0.12, 0.14], nearer: 0.002 });
    }
    this.drawUnder(ratio);
    this.drawOver(ratio);
  }

  drawMesh(kind, places, indices, values, { plain = null, lit = false, nearer = 0 }) {
    const gl = this.gl;
    const put = (name, target, data) => {
      if (!this.buffers.has(name)) this.buffers.set(name, gl.createBuffer());
      gl.bindBuffer(target, this.buffers.get(name));
      gl.bufferData(target, data, gl.DYNAMIC_DRAW);
    };
    put("places", gl.ARRAY_BUFFER, places);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    put("values", gl.ARRAY_BUFFER, values || new Float32Array(places.length / 3));
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 1, gl.FLOAT, false, 0, 0);
    put("indices", gl.ELEMENT_ARRAY_BUFFER, indices);
    gl.uniform4f(this.at("plain"), ...(plain || [0, 0, 0]), values ? 0 : 1);
    gl.uniform1i(this.at("lit"), Number(lit));
    gl.uniform1f(this.at("nearer"), nearer);
    gl.drawElements(kind, indices.length, gl.UNSIGNED_INT, 0);
  }

  /** Return where a point is on the stage [pixel], and how near [length]. */
  seen(places, index) {
    const { centre, pixels, wide, tall } = this.fitted, r = this.rotated;
    const p = [0, 1, 2].map(axis => places[3 * index + axis] - centre[axis]);
    const [x, y, z] = r.map(row => row[0] * p[0] + row[1] * p[1] + row[2] * p[2]);
    return [wide / 2 + this.view.x + x * pixels, tall / 2 + this.view.y - y * pixels, z];
  }

  brush(canvas, ratio) {
    const brush = canvas.getContext("2d");
    brush.setTransform(ratio, 0, 0, ratio, 0, 0);
    brush.clearRect(0, 0, canvas.width, canvas.height);
    return brush;
  }

  /** Tint the lumens, so that only gaps and the outside are white, hatch those of free cells, and fill rigid bodies. */
  drawUnder(ratio) {
    const brush = this.brush(this.part.under, ratio), { shape, level } = this.state, free = new Set(level.free);
    this.fill(brush, shape.loops, "#e4e9ef", cell => !free.has(cell));
    this.fill(brush, shape.loops, this.hatched(brush), cell => free.has(cell));
    this.fill(brush, shape.rigid, "#aab0b8", () => true);
  }

  hatched(brush) {
    const tile = document.createElement("canvas"), pen = tile.getContext("2d");
    Object.assign(tile, { width: 9, height: 9 });
    Object.assign(pen, { fillStyle: "#f3f5f7", strokeStyle: "#8a93a0", lineWidth: 1.2 });
    pen.fillRect(0, 0, 9, 9);
    for (const x of [-9, 0, 9]) { pen.moveTo(x - 1, 10); pen.lineTo(x + 10, -1); }
    pen.stroke();
    return brush.createPattern(tile, "repeat");
  }

  fill(brush, loops, style, wanted) {
    const { shape, places } = this.state;
    brush.fillStyle = style;
    brush.beginPath();
    let first = true;
    for (const index of loops) {
      if (index >= 0 && !wanted(shape.owner[index])) continue;
      if (index < 0) { brush.closePath(); first = true; continue; }
      const [x, y] = this.seen(places, index);
      if (first) brush.moveTo(x, y); else brush.lineTo(x, y);
      first = false;
    }
    brush.fill();
  }

  drawOver(ratio) {
    const brush = this.brush(this.part.over, ratio);
    if (!this.data.solid) {
      this.outline(brush);
      if (this.state.field.where === "walls") this.drawWalls(brush);
    }
    this.nameBodies(brush);
  }

  outline(brush) {
    const { shape, places, level } = this.state, free = new Set(level.free);
    for (const dashed of [false, true]) {
      let length = 0;  // lines follow each other around a cell: dashes go on from one to the next
      brush.beginPath();
      for (let i = 0; i < shape.lines.length / 2; i++) {
        if (free.has(shape.owner[shape.lines[2 * i]]) !== dashed) continue;
        const [x, y] = this.seen(places, shape.lines[2 * i]), [u, v] = this.seen(places, shape.lines[2 * i + 1]);
        length += Math.hypot(u - x, v - y);
        if (dashed && length % 10 > 6) continue;
        brush.moveTo(x, y);
        brush.lineTo(u, v);
      }
      brush.strokeStyle = dashed ? "#a3001b" : "#22272c";
      brush.lineWidth = Math.max(0.5, Math.min(dashed ? 1.6 : 0.8, 0.035 * this.fitted.pixels));
      brush.stroke();
    }
  }

  drawWalls(brush) {
    const { shape, walls, values } = this.state, [low, high] = this.span();
    brush.lineWidth = Math.max(3, 0.045 * this.fitted.pixels);
    brush.lineCap = "round";
    for (let i = 0; i < shape.walls.length; i += 2) {
      const one = shape.walls[i], two = shape.walls[i + 1];
      if (values[one] < 0 || values[two] < 0) continue;
      const share = Math.max(0, Math.min(1, ((values[one] + values[two]) / 2 - low) / (high - low)));
      const place = 3 * Math.round(255 * share);
      brush.strokeStyle = `rgb(${COLOURS[place]} ${COLOURS[place + 1]} ${COLOURS[place + 2]})`;
      brush.beginPath();
      brush.moveTo(...this.seen(walls, one).slice(0, 2));
      brush.lineTo(...this.seen(walls, two).slice(0, 2));
      brush.stroke();
    }
  }

  /** Say which bodies are rigid, and, where it is asked for, the number of each cell. */
  nameBodies(brush) {
    const { shape, places } = this.state, sums = new Map();
    const rigid = new Set(Array.from(shape.rigid).filter(index => index >= 0).map(index => shape.owner[index]));
    for (let i = 0; i < shape.owner.length; i++) {
      if (!rigid.has(shape.owner[i]) && !this.part.names.checked) continue;
      const sum = sums.get(shape.owner[i]) || [0, 0, 0, 0];
      for (let a = 0; a < 3; a++) sum[a] += places[3 * i + a];
      sum[3]++;
      sums.set(shape.owner[i], sum);
    }
    Object.assign(brush, { font: "600 12px system-ui, sans-serif", textAlign: "center", textBaseline: "middle", lineWidth: 3, strokeStyle: "#fffc", fillStyle: "#111" });
    for (const [cell, sum] of sums) {
      const [x, y] = this.seen(sum.map(value => value / sum[3]), 0);
      const words = rigid.has(cell) ? "rigid" : String(cell);
      if (!rigid.has(cell)) brush.strokeText(words, x, y);
      brush.fillText(words, x, y);
    }
  }

  /** Tell the value at the point nearest to the pointer. */
  read(event) {
    if (!this.state) return;
    const box = this.part.stage.getBoundingClientRect(), { field, shape, places, walls, values } = this.state;
    const points = field.where === "bodies" ? places : walls, x = event.clientX - box.left, y = event.clientY - box.top;
    let best = -1, least = 14 * 14;
    for (let i = 0; i < points.length / 3; i++) {
      if (values[i] < 0) continue;
      const [u, v, z] = this.seen(points, i), apart = (u - x) ** 2 + (v - y) ** 2 - (this.data.solid ? 60 * z / this.fitted.radius : 0);
      if ((u - x) ** 2 + (v - y) ** 2 < 196 && apart < least) { least = apart; best = i; }
    }
    const cell = best >= 0 && field.where === "bodies" ? `cell ${shape.owner[best]}: ` : "";
    const value = best >= 0 ? valueOf(field, values[best]) : NaN;
    this.part.reading.textContent = best >= 0 ? `${cell}${field.title} ${shown(value)}` : "";
  }
}

const players = [...document.querySelectorAll(".player")].map(root => new Player(root));
for (const player of players) {
  player.root.addEventListener("level", () => {
    if (!document.getElementById("together")?.checked) return;
    for (const other of players) if (other !== player && other.gl) {
      other.part.level.value = String(Math.min(player.level, other.data.levels.length - 1));
      other.show();
    }
  });
  player.start();
}
