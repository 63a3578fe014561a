// 3-D view of a ring in motion. The page holds one sector; the graphics card draws it N times.
//
// Sector j of a wave of nodal diameter ND moves by Re(x_j e^{iα}), and in cylindrical components
// x_j = x_0 e^{-i j ND 2π/N}: sector 0's displacement, later by the phase lag, turned with the
// sector about the engine axis z. The vertex shader does just that, so a new phase angle α costs
// one uniform; cosines and sines are JavaScript's, since graphics cards' have four digits. vanelock.render.scenes.annulus is the same in Python; a test compares the two.
(() => {
  "use strict";

  const VERTEX = `#version 300 es
  in vec3 place, normal, re, im;    // fractions of the body's box; of the motion's unit
  in vec4 around;                   // cos, sin of the sector's angle j 2π/N and of its lag j ND 2π/N
  uniform vec3 low, span;           // the box, m
  uniform float unit, largest;      // m: largest component, largest displacement in a cycle
  uniform vec2 alpha;               // cos, sin of the phase angle
  uniform float scale;              // displacements are drawn that many times as large
  uniform mat3 view;                // to right, up, backward
  uniform vec3 centre;
  uniform vec2 fit;                 // 1/m, to the picture's half width and half height
  uniform float radius, nearer;     // m; lines are drawn a little nearer than faces
  uniform bool instant;             // value: displacement at this instant, else over a cycle
  out vec3 position, facing;
  out float value;

  void main() {
    float c = dot(alpha, around.zw), s = alpha.y * around.z - alpha.x * around.w;  // of α - j φ
    vec3 moved = unit * (re * c - im * s);
    mat3 turned = mat3(around.x, around.y, 0.0, -around.y, around.x, 0.0, 0.0, 0.0, 1.0);
    position = turned * (low + span * place + scale * moved);
    // A point runs along an ellipse; its larger half axis is the amplitude.
    vec2 square = vec2(dot(re, re) - dot(im, im), 2.0 * dot(re, im));
    float amplitude = unit * sqrt((dot(re, re) + dot(im, im) + length(square)) / 2.0);
    value = (instant ? length(moved) : amplitude) / largest;
    facing = view * (turned * normal);
    vec3 seen = view * (position - centre);
    const float DEPTH = 0.2, REACH = 2.5;  // a mild perspective, of what lies within REACH radii
    float w = 1.0 - DEPTH * seen.z / radius;
    float front = 1.0 - DEPTH * REACH, back = 1.0 + DEPTH * REACH;
    float a = 2.0 / (1.0 / back - 1.0 / front), b = 1.0 - a / back;
    gl_Position = vec4(seen.xy * fit, a + b * w - nearer * w, w);
  }`;

  const FRAGMENT = `#version 300 es
  precision highp float;
  in vec3 position, facing;
  in float value;
  uniform vec3 stops[11], plain;
  uniform bool coloured, line;
  out vec4 pixel;

  void main() {
    if (line) { pixel = vec4(0.1, 0.1, 0.1, 0.5); return; }
    float t = clamp(value, 0.0, 1.0) * 10.0;
    int i = min(int(t), 9);
    vec3 base = coloured ? mix(stops[i], stops[i + 1], t - float(i)) : plain;
    vec3 n = normalize(facing);
    float light = 0.5 + 0.3 * max(n.z, 0.0) + 0.28 * max(dot(n, normalize(vec3(-0.7, 0.9, 0.8))), 0.0);
    pixel = vec4(min(base * light, 1.0), 1.0);
  }`;

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
  const short = (x) => Number(x.toPrecision(3)).toLocaleString("en-GB", { maximumSignificantDigits: 3 });

  // Each sector's `around`, for a wave.
  const sectorAngles = (sectors, diameter) =>
    Float32Array.from({ length: 4 * sectors }, (_, i) => {
      const j = i >> 2, angle = 2 * Math.PI * ((i & 2 ? j * diameter : j) % sectors) / sectors;
      return i & 1 ? Math.sin(angle) : Math.cos(angle);
    });

  function program(gl) {
    const made = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
    return made;
  }

  // A buffer of rows of three numbers (padded to four), read as fractions.
  function attribute(gl, made, name, text, type) {
    const place = gl.getAttribLocation(made, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, bytes(text), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, type, true, type === gl.BYTE ? 4 : 8, 0);
  }

  function indices(gl, text) {
    const data = bytes(text), buffer = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return { buffer, count: data.length / 4 };
  }

  class Viewer {
    constructor(figure) {
      this.figure = figure;
      this.canvas = figure.querySelector("canvas");
      const options = { antialias: true, alpha: false, preserveDrawingBuffer: true };
      this.gl = this.canvas.getContext("webgl2", options);
      if (!this.gl) throw new Error("no WebGL 2");
      this.scene = JSON.parse(figure.querySelector("script").textContent);
      this.control = (name) => figure.querySelector(`[data-control="${name}"]`);
      this.program = program(this.gl);
      this.where = {};  // uniforms
      for (let i = 0; i < this.gl.getProgramParameter(this.program, this.gl.ACTIVE_UNIFORMS); i++) {
        const name = this.gl.getActiveUniform(this.program, i).name;
        this.where[name.replace("[0]", "")] = this.gl.getUniformLocation(this.program, name);
      }
      this.bodies = this.scene.bodies.map((body, i) => this.upload(body, i));
      this.playing = false;
      this.visible = true;
      this.slow = 0;  // frames in a row
      this.pointers = new Map();
      this.choose(0);
      this.look();
      this.connect();
      this.wish();
    }

    // One vertex array for each motion of a body: they differ in the displacements alone.
    upload(body, which) {
      const gl = this.gl;
      const arrays = this.scene.motions.map((motion) => {
        const array = gl.createVertexArray();
        gl.bindVertexArray(array);
        attribute(gl, this.program, "place", body.points, gl.UNSIGNED_SHORT);
        attribute(gl, this.program, "normal", body.normals, gl.BYTE);
        attribute(gl, this.program, "re", motion.shapes[which].re, gl.SHORT);
        attribute(gl, this.program, "im", motion.shapes[which].im, gl.SHORT);
        const around = gl.getAttribLocation(this.program, "around");
        gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
        gl.bufferData(gl.ARRAY_BUFFER, sectorAngles(this.scene.sectors, motion.diameter), gl.STATIC_DRAW);
        gl.enableVertexAttribArray(around);
        gl.vertexAttribPointer(around, 4, gl.FLOAT, false, 0, 0);
        gl.vertexAttribDivisor(around, 1);  // one for each sector
        return array;
      });
      const made = { ...body, arrays, faces: indices(gl, body.triangles), lines: indices(gl, body.outline) };
      gl.bindVertexArray(null);
      return made;
    }

    get ring() { return this.control("extent").value === "ring"; }

    choose(number) {
      this.number = number;
      this.motion = this.scene.motions[number];
      this.alpha = this.motion.instant;
      this.tell();
    }

    look() {
      const camera = this.scene.cameras[this.ring ? "ring" : "sector"];
      this.rows = camera.rows.map((row) => [...row]);
      this.centre = [...camera.centre];
      this.radius = camera.radius;
      this.zoom = 1;
    }

    // Words and numbers beside the picture.
    tell() {
      const motion = this.motion, scale = motion.scale * Number(this.control("exaggeration").value);
      const colouring = this.control("colouring").value, top = motion.relative ? 1 : 1e6 * motion.largest;
      const drawn = motion.relative
        ? `largest displacement drawn as ${short(1e3 * scale * motion.largest)} mm`
        : `largest amplitude ${short(top)} µm, drawn ${short(scale)} times as large`;
      const frequency = motion.frequency === null ? "" : `${Number(motion.frequency.toPrecision(4))} Hz, `;
      this.figure.querySelector(".status").textContent =
        `${frequency}${motion.wave}; ${drawn}. ${motion.note}`;
      this.control("exaggeration").nextElementSibling.textContent =
        motion.relative ? `${short(1e3 * scale * motion.largest)} mm` : `× ${short(scale)}`;
      this.scale = scale;
      const bar = this.figure.querySelector(".bar");
      bar.style.visibility = colouring === "part" ? "hidden" : "visible";
      bar.querySelector(".bar-label").textContent =
        (colouring === "instant" ? "displacement now" : "amplitude") + (motion.relative ? " / largest (–)" : " (µm)");
      const step = [1, 2, 2.5, 5, 10].map((s) => s * 10 ** Math.floor(Math.log10(top / 4))).find((s) => top / s <= 5);
      const ticks = [];
      for (let k = 0; k * step <= top * 1.0001; k++) {
        const tick = document.createElement("span");
        tick.textContent = String(Number((k * step).toPrecision(6)));
        tick.style.setProperty("--at", k * step / top);
        ticks.push(tick);
      }
      bar.querySelector(".bar-scale").replaceChildren(...ticks);
    }

    // Ask for a picture; at most one is drawn a frame.
    wish() {
      if (!this.asked) this.asked = requestAnimationFrame((time) => this.frame(time));
    }

    frame(time) {
      this.asked = 0;
      if (this.playing && this.visible) {
        const gap = this.last ? time - this.last : 0;
        this.alpha += 2 * Math.PI * Math.min(gap, 100) / 2000;  // 2 s a cycle
        this.slow = gap > 250 ? this.slow + 1 : 0;
        if (this.unasked && this.slow === 3) this.play(false);  // no graphics card: leave it in peace
        this.last = time;
        this.wish();
      } else this.last = 0;
      this.draw();
    }

    draw() {
      const { gl, canvas, where, motion, scene } = this;
      const fine = Math.min(window.devicePixelRatio || 1, 2);
      const width = Math.round(canvas.clientWidth * fine), height = Math.round(canvas.clientHeight * fine);
      if (width && height && (canvas.width !== width || canvas.height !== height)) {
        canvas.width = width;
        canvas.height = height;
      }
      const degrees = ((this.alpha * 180 / Math.PI) % 360 + 360) % 360;
      this.control("phase").value = degrees;
      this.control("phase").nextElementSibling.textContent = `${Math.round(degrees) % 360}°`;
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(1, 1, 1, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.enable(gl.CULL_FACE);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      gl.useProgram(this.program);
      const colouring = this.control("colouring").value;
      const short = Math.min(canvas.width, canvas.height), fit = 0.95 * this.zoom / this.radius;
      const numbers = {
        unit: motion.unit, largest: motion.largest, scale: this.scale, radius: this.radius,
      };
      for (const [name, number] of Object.entries(numbers)) gl.uniform1f(where[name], number);
      gl.uniform2f(where.alpha, Math.cos(this.alpha), Math.sin(this.alpha));
      gl.uniform1i(where.instant, colouring === "instant");
      gl.uniform1i(where.coloured, colouring !== "part");
      gl.uniform3fv(where.centre, this.centre);
      gl.uniform2f(where.fit, fit * short / canvas.width, fit * short / canvas.height);
      gl.uniformMatrix3fv(where.view, true, this.rows.flat());
      gl.uniform3fv(where.stops, scene.colours.flatMap(rgb));
      const copies = this.ring ? scene.sectors : 1;
      for (const line of [false, true]) {
        gl.uniform1i(where.line, line);
        gl.uniform1f(where.nearer, line ? 4e-4 / this.zoom : 0);
        line ? gl.enable(gl.BLEND) : gl.disable(gl.BLEND);
        for (const body of this.bodies) {
          gl.bindVertexArray(body.arrays[this.number]);
          gl.uniform3fv(where.low, body.low);
          gl.uniform3fv(where.span, body.span);
          gl.uniform3fv(where.plain, rgb(body.colour));
          const drawn = line ? body.lines : body.faces;
          gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, drawn.buffer);
          gl.drawElementsInstanced(line ? gl.LINES : gl.TRIANGLES, drawn.count, gl.UNSIGNED_INT, 0, copies);
        }
      }
    }

    // Turn what is seen: to the right and downwards, rad.
    rotate(right, down) {
      const [x, y, z] = this.rows, mix = (a, p, b, q) => a.map((v, i) => v * p + b[i] * q);
      const across = mix(x, Math.cos(right), z, Math.sin(right));
      const near = mix(z, Math.cos(right), x, -Math.sin(right));
      const up = mix(y, Math.cos(down), near, -Math.sin(down));
      this.rows = [across, up, mix(near, Math.cos(down), y, Math.sin(down))];
      this.wish();
    }

    // Shift what is seen by pixels of the page.
    pan(right, down) {
      const box = this.canvas.getBoundingClientRect();
      const metres = 2 * this.radius / (0.95 * this.zoom * Math.min(box.width, box.height));
      this.centre = this.centre.map((c, i) => c - metres * (right * this.rows[0][i] - down * this.rows[1][i]));
      this.wish();
    }

    magnify(factor) {
      this.zoom = Math.min(Math.max(this.zoom * factor, 0.3), 40);
      this.wish();
    }

    play(on) {
      this.playing = on;
      this.control("play").textContent = on ? "Pause" : "Play";
      this.wish();
    }

    connect() {
      const { canvas, control } = this;
      control("motion").addEventListener("change", (e) => { this.choose(Number(e.target.value)); this.wish(); });
      control("play").addEventListener("click", () => { this.unasked = false; this.play(!this.playing); });
      control("phase").addEventListener("input", (e) => {
        this.alpha = e.target.value * Math.PI / 180;
        this.play(false);
      });
      for (const name of ["exaggeration", "colouring"])
        control(name).addEventListener("input", () => { this.tell(); this.wish(); });
      control("extent").addEventListener("change", () => { this.look(); this.wish(); });
      control("reset").addEventListener("click", () => { this.look(); this.wish(); });
      canvas.addEventListener("pointerdown", (e) => {
        canvas.setPointerCapture(e.pointerId);
        canvas.focus({ preventScroll: true });
        this.pointers.set(e.pointerId, [e.clientX, e.clientY]);
      });
      canvas.addEventListener("pointermove", (e) => this.drag(e));
      for (const name of ["pointerup", "pointercancel"])
        canvas.addEventListener(name, (e) => this.pointers.delete(e.pointerId));
      canvas.addEventListener("contextmenu", (e) => e.preventDefault());
      canvas.addEventListener("dblclick", () => { this.look(); this.wish(); });
      canvas.addEventListener("wheel", (e) => {  // scrolls the page unless the picture was clicked
        if (document.activeElement !== canvas) return;
        e.preventDefault();
        this.magnify(Math.exp(-e.deltaY * (e.deltaMode ? 0.05 : 0.0015)));
      }, { passive: false });
      canvas.addEventListener("keydown", (e) => this.key(e));
      canvas.addEventListener("webglcontextlost", () => message(this.figure));
      new ResizeObserver(() => this.wish()).observe(canvas);
      new IntersectionObserver(([entry]) => {
        this.visible = entry.isIntersecting;
        this.wish();
      }).observe(canvas);
      window.addEventListener("beforeprint", () => this.draw());
      this.unasked = !matchMedia("(prefers-reduced-motion: reduce)").matches;
      if (this.unasked) this.play(true);
    }

    drag(event) {
      const before = this.pointers.get(event.pointerId);
      if (!before) return;
      const now = [event.clientX, event.clientY], dx = now[0] - before[0], dy = now[1] - before[1];
      const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
      if (other) {  // two fingers: their distance magnifies, their middle shifts
        const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
        this.magnify(apart(now) / Math.max(apart(before), 1));
        this.pan(dx / 2, dy / 2);
      } else if (event.shiftKey || event.buttons & 6) this.pan(dx, dy);
      else {
        const size = Math.min(this.canvas.clientWidth, this.canvas.clientHeight);
        this.rotate(Math.PI * dx / size, Math.PI * dy / size);
      }
      this.pointers.set(event.pointerId, now);
    }

    key(event) {
      const acts = {
        ArrowLeft: () => this.rotate(-0.1, 0), ArrowRight: () => this.rotate(0.1, 0),
        ArrowUp: () => this.rotate(0, -0.1), ArrowDown: () => this.rotate(0, 0.1),
        "+": () => this.magnify(1.15), "-": () => this.magnify(1 / 1.15),
        0: () => { this.look(); this.wish(); }, " ": () => this.control("play").click(),
      };
      if (!acts[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      acts[event.key]();
    }
  }

  function message(figure) {
    figure.classList.add("without");
    figure.querySelector(".missing").hidden = false;
  }

  for (const figure of document.querySelectorAll("figure.view")) {
    try { new Viewer(figure); } catch (error) { message(figure); }
  }
  window.vanelockView = { vertexShader: VERTEX, sectorAngles };
})();
