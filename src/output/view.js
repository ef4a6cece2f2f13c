// Draws the scene of this page in false colours with WebGL, and shows the values at the picked point.
"use strict";
(async () => {
  const view = document.getElementById("view");
  const find = (selector) => view.querySelector(selector), all = (selector) => [...view.querySelectorAll(selector)];
  const canvas = find("canvas"), words = find("output");
  const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
  if (!gl || typeof DecompressionStream === "undefined") return; // The plots of the page show the same values.

  // Each column holds 16-bit codes as differences to the previous code: all low bytes first, then all high bytes.
  const about = JSON.parse(document.getElementById("view-about").textContent);
  const packed = Uint8Array.from(atob(document.getElementById("view-data").textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  let offset = 0, waiting = false, travelled = 0;
  const column = (length) => {
    const codes = new Uint16Array(length);
    for (let i = 0, code = 0; i < length; i++) {
      code = (code + bytes[offset + i] + 256 * bytes[offset + length + i]) & 65535;
      codes[i] = code;
    }
    offset += 2 * length;
    return codes;
  };
  const count = about.facets, columns = (number, length) => Array.from({ length: number }, () => column(length));
  const corners = columns(9, count), part = column(count), means = columns(4, count);
  const atCorners = about.is_sloped ? columns(3, count) : [means[0], means[0], means[0]];
  const ends = columns(6, about.lines);
  const lux = (code) => code === 65535 ? NaN : code === 0 ? 0 : about.most_lx * Math.exp(((code - 1) / 65533 - 1) * about.span);
  const fingers = new Map(), sets = []; // touching fingers, and receiver sets
  for (let i = about.surface_facets; i < count; i++) {
    if (sets.at(-1)?.set === part[i]) sets.at(-1).length++;
    else sets.push({ first: i, length: 1, set: part[i] });
  }
  const isShown = (set) => state.set === "all" || state.set === String(set);
  const place = (code, axis) => about.low_m[axis] + about.step_m * code;

  // Corners of triangles relative to the middle of the scene. Single precision is then sufficient.
  const low = [0, 1, 2].map((axis) => Infinity), high = low.map((bound) => -bound);
  corners.forEach((codes, k) => codes.forEach((code) => {
    low[k % 3] = Math.min(low[k % 3], place(code, k % 3));
    high[k % 3] = Math.max(high[k % 3], place(code, k % 3));
  }));
  const middle = low.map((bound, axis) => (bound + high[axis]) / 2), size = Math.hypot(...low.map((bound, axis) => high[axis] - bound)) || 1;
  const triangles = new Float32Array(9 * count), lines = new Float32Array(6 * about.lines);
  for (let k = 0; k < 9; k++) for (let i = 0; i < count; i++) triangles[9 * i + k] = place(corners[k][i], k % 3) - middle[k % 3];
  for (let k = 0; k < 6; k++) for (let i = 0; i < about.lines; i++) lines[6 * i + k] = place(ends[k][i], k % 3) - middle[k % 3];
  const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]], dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const along = (a, b, t) => [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]];
  const corner = (i, k) => [triangles[9 * i + 3 * k], triangles[9 * i + 3 * k + 1], triangles[9 * i + 3 * k + 2]];

  const put = (buffer, numbers) => { gl.bindBuffer(gl.ARRAY_BUFFER, buffer); gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.STATIC_DRAW); };
  // Facets without a value are grey, lighter or darker by their orientation: codes −1 to −2. Outlines have −5, luminaires −6, the picked point −7.
  const shade = (i) => {
    const normal = cross(sub(corner(i, 1), corner(i, 0)), sub(corner(i, 2), corner(i, 0)));
    return -1.5 - dot(normal, [0.25, 0.15, 0.4]) / (Math.hypot(...normal) || 1);
  };
  const values = new Float32Array(3 * count);
  const fill = () => {
    const shown = state.quantity === 0 ? atCorners : [0, 1, 2].map(() => means[state.quantity]);
    for (let i = 0; i < count; i++) {
      for (let k = 0; k < 3; k++) {
        const value = lux(shown[k][i]);
        values[3 * i + k] = Number.isNaN(value) ? shade(i) : value / state.end;
      }
    }
    put(buffers.values, values);
  };

  const program = gl.createProgram();
  const add = (kind, source) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  };
  add(gl.VERTEX_SHADER, `
    attribute vec3 at; attribute float value; uniform mat4 camera; varying float v; varying float z;
    void main() { v = value; z = at.z; gl_Position = camera * vec4(at, 1.0); }`);
  add(gl.FRAGMENT_SHADER, `
    precision highp float; varying float v; varying float z; uniform float cut; uniform sampler2D colors;
    void main() {
      if (z > cut) discard;
      if (v < -6.5) gl_FragColor = vec4(0.84, 0.37, 0.0, 1.0);
      else if (v < -5.5) gl_FragColor = vec4(0.94, 0.67, 0.08, 1.0);
      else if (v < -4.5) gl_FragColor = vec4(0.18, 0.18, 0.18, 1.0);
      else if (v < -0.5) gl_FragColor = vec4(vec3(1.08 + 0.2 * v), 1.0);
      else gl_FragColor = texture2D(colors, vec2((clamp(v, 0.0, 1.0) * ${about.colors.length - 1}.0 + 0.5) / ${about.colors.length}.0, 0.5));
    }`);
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return;
  gl.useProgram(program);
  const [AT, VALUE] = ["at", "value"].map((name) => gl.getAttribLocation(program, name));
  const [CAMERA, CUT] = ["camera", "cut"].map((name) => gl.getUniformLocation(program, name));
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, about.colors.length, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array(about.colors.flat()));
  for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
  for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
  const buffers = { triangles: gl.createBuffer(), values: gl.createBuffer(), lines: gl.createBuffer(), mark: gl.createBuffer() };
  put(buffers.triangles, triangles);
  put(buffers.lines, lines);
  gl.enable(gl.DEPTH_TEST);
  gl.clearColor(0.957, 0.957, 0.949, 1);
  const SLOPE = Math.tan(0.35); // of half the angle of view
  const HOME = { yaw: 1.05, pitch: 0.62, distance: 1.3 * size, target: [0, 0, 0], top: false };
  const state = { ...HOME, quantity: 0, end: about.ends_lx[0], surfaces: true, set: "all", cut: high[2], mark: null };
  // The eye: its right, up and forward directions, its position, and half the visible height in m at the distance of its target.
  const eye = () => {
    const yaw = state.top ? Math.PI / 2 : state.yaw, pitch = state.top ? Math.PI / 2 : state.pitch;
    const forward = [Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), -Math.sin(pitch)];
    const right = [Math.sin(yaw), -Math.cos(yaw), 0];
    const reach = state.top ? 2 * size : state.distance;
    return { forward, right, up: cross(right, forward), from: along(state.target, forward, -reach), half: SLOPE * state.distance, aspect: canvas.width / canvas.height };
  };
  const matrix = ({ forward, right, up, from, half, aspect }) => {
    const near = state.top ? 0 : Math.max(state.distance - 2 * size, 0.005 * size), far = (state.top ? 2 * size : state.distance) + 2 * size;
    const wide = state.top ? half : SLOPE;
    const row = (axis, scale, shift) => [...axis.map((x) => x * scale), shift - scale * dot(axis, from)];
    const depth = state.top ? row(forward, 2 / (far - near), -1) : row(forward, (far + near) / (far - near), -2 * far * near / (far - near));
    const rows = [row(right, 1 / (wide * aspect), 0), row(up, 1 / wide, 0), depth, state.top ? [0, 0, 0, 1] : row(forward, 1, 0)];
    return [0, 1, 2, 3].flatMap((k) => rows.map((numbers) => numbers[k]));
  };
  const draw = () => {
    waiting = false;
    const ratio = window.devicePixelRatio || 1;
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(CAMERA, false, matrix(eye()));
    gl.uniform1f(CUT, state.cut - middle[2] + 1e-4 * size);
    const use = (buffer, location, width) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, width, gl.FLOAT, false, 0, 0);
    };
    use(buffers.triangles, AT, 3);
    use(buffers.values, VALUE, 1);
    gl.enable(gl.CULL_FACE);
    gl.enable(gl.POLYGON_OFFSET_FILL); // Draws outlines and receivers in front of the surfaces that they lie on.
    gl.polygonOffset(2, 2);
    if (state.surfaces) gl.drawArrays(gl.TRIANGLES, 0, 3 * about.surface_facets);
    gl.disable(gl.CULL_FACE);
    for (const { first, length, set } of sets.filter(({ set }) => isShown(set))) {
      gl.polygonOffset(1 - set, 1 - set); // If sets lie in one plane, later sets are drawn on top.
      gl.drawArrays(gl.TRIANGLES, 3 * first, 3 * length);
    }
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.disableVertexAttribArray(VALUE);
    use(buffers.lines, AT, 3);
    gl.vertexAttrib1f(VALUE, -5);
    gl.drawArrays(gl.LINES, 0, 2 * about.outlines);
    gl.vertexAttrib1f(VALUE, -6);
    gl.drawArrays(gl.LINES, 2 * about.outlines, 2 * (about.lines - about.outlines));
    if (state.mark) {
      const arm = 0.03 * state.distance;
      put(buffers.mark, new Float32Array([0, 1, 2].flatMap((axis) => [-arm, arm].flatMap((shift) => state.mark.map((x, k) => k === axis ? x + shift : x)))));
      use(buffers.mark, AT, 3);
      gl.vertexAttrib1f(VALUE, -7);
      gl.disable(gl.DEPTH_TEST);
      gl.drawArrays(gl.LINES, 0, 6);
      gl.enable(gl.DEPTH_TEST);
    }
  };
  const redraw = () => { if (!waiting) { waiting = true; requestAnimationFrame(draw); } };

  // Returns the first triangle that the ray through the point (x, y) of the picture meets. x and y run from −1 to 1.
  const pick = (x, y) => {
    const { forward, right, up, from, half, aspect } = eye();
    const start = state.top ? along(along(from, right, x * half * aspect), up, y * half) : from;
    const direction = state.top ? forward : along(along(forward, right, x * SLOPE * aspect), up, y * SLOPE);
    let best = null, nearest = Infinity;
    for (let i = state.surfaces ? 0 : about.surface_facets; i < count; i++) {
      const a = corner(i, 0), ab = sub(corner(i, 1), a), ac = sub(corner(i, 2), a);
      const p = cross(direction, ac), determinant = dot(ab, p);
      if (i < about.surface_facets ? determinant <= 0 : determinant === 0 || !isShown(part[i])) continue;
      const s = sub(start, a), u = dot(s, p) / determinant, q = cross(s, ab), v = dot(direction, q) / determinant;
      const t = dot(ac, q) / determinant - (i < about.surface_facets ? 0 : 1e-5 * (10 + part[i]) * size);
      if (u < 0 || v < 0 || u + v > 1 || t <= 0 || t >= nearest) continue;
      const at = along(start, direction, t);
      if (at[2] + middle[2] > state.cut + 1e-4 * size) continue;
      [nearest, best] = [t, { i, at, weights: [1 - u - v, u, v] }];
    }
    return best;
  };
  // Numbers are rounded as in the tables of the page: values to two digits, errors to one or two.
  const say = (number, ...values) => about.readings[number].split("{}").map((words, k) => words + (values[k] ?? "")).join(""), local = (number) => number.replace(".", about.decimal_sign);
  const rounded = (x, digits) => x === 0 ? "0" : x.toFixed(Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(x)))));
  const luxWords = (x) => local(rounded(x, 2)), errorWords = (x) => local(rounded(x, /^[0.]*1/.test(x.toPrecision(2)) ? 2 : 1));
  const read = (x, y) => {
    const hit = pick(x, y);
    state.mark = hit?.at;
    words.textContent = hit ? reading(hit) : say(0);
    redraw();
  };
  const reading = ({ i, at, weights }) => {
    const [mean, direct, indirect, error] = means.map((codes) => lux(codes[i]));
    const name = about.parts[part[i]], inMetres = (k) => local((Math.round(100 * (at[k] + middle[k])) / 100 + 0).toFixed(2));
    const where = `x ${inMetres(0)}; y ${inMetres(1)}; z ${inMetres(2)}`;
    if (Number.isNaN(mean)) return say(1, name, where);
    if (mean < error) return say(2, name, luxWords(mean + 2 * error), where);
    const here = luxWords(weights.reduce((sum, weight, k) => sum + weight * lux(atCorners[k][i]), 0)), told = [name, luxWords(mean), errorWords(error)];
    return say(...about.is_sloped && i < about.surface_facets ? [4, ...told, here] : [3, ...told], luxWords(direct), luxWords(indirect), where);
  };

  const show = (quantity) => {
    Object.assign(state, { quantity, end: about.ends_lx[quantity] });
    all("[data-quantity]").forEach((button) => button.setAttribute("aria-pressed", button.dataset.quantity === String(quantity)));
    scale();
  };
  const scale = () => {
    find("[data-end]").value = Number(state.end.toPrecision(3));
    find(".ticks").replaceChildren(...[0, 1, 2, 3, 4, 5].map((k) => {
      const tick = document.createElement("span");
      tick.textContent = `${k === 5 ? "≥ " : ""}${local(String(Number(rounded(state.end * k / 5, 3))))}${k === 5 ? " lx" : ""}`;
      return tick;
    }));
    fill();
    redraw();
  };
  const cut = (share) => {
    state.cut = share < 1 ? low[2] + share * (high[2] - low[2]) : 1e9; // Luminaires may hang above all surfaces.
    find("[data-cut-words]").textContent = `${local(Math.min(state.cut, high[2]).toFixed(2))} m`;
    redraw();
  };
  const turn = (x, y) => { state.top = false; state.yaw -= x; state.pitch = Math.min(1.57, Math.max(-1.57, state.pitch + y)); redraw(); };
  const move = (x, y) => { // in units of half the picture's height
    const { right, up, half } = eye();
    state.target = along(along(state.target, right, -x * half), up, y * half);
    redraw();
  };
  const zoom = (factor) => { state.distance = Math.min(20 * size, Math.max(0.002 * size, state.distance * factor)); redraw(); };
  const look = (name) => {
    Object.assign(state, HOME, { top: name === "top" });
    const fitting = 0.55 * Math.max(high[1] - low[1], (high[0] - low[0]) * canvas.clientHeight / canvas.clientWidth) / SLOPE;
    if (state.top && fitting > 0) state.distance = fitting;
    redraw();
  };

  all("[data-quantity]").forEach((button) => button.addEventListener("click", () => show(Number(button.dataset.quantity))));
  find("[data-surfaces]").addEventListener("change", (event) => { state.surfaces = event.target.checked; redraw(); });
  find("select").append(...sets.map(({ set }) => new Option(about.parts[set], set)));
  find("select").addEventListener("change", (event) => { state.set = event.target.value; redraw(); });
  all("[data-do]").forEach((button) => button.addEventListener("click", () => look(button.dataset.do)));
  find("[data-cut]").addEventListener("input", (event) => cut(event.target.value / 1000));
  find("[data-end]").addEventListener("change", (event) => { if (event.target.value > 0) { state.end = Number(event.target.value); scale(); } });
  const keys = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  canvas.addEventListener("keydown", (event) => {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (keys[key]) event.shiftKey || state.top ? move(...keys[key].map((x) => 0.1 * x)) : turn(...keys[key].map((x) => 0.08 * x));
    else if ("1234".includes(key)) show(Number(key) - 1);
    else if (key === "+" || key === "=") zoom(0.85);
    else if (key === "-") zoom(1 / 0.85);
    else if (key === "t" || key === "h") look(key === "t" ? "top" : "home");
    else if (key === "Enter") read(0, 0);
    else return;
    event.preventDefault();
  });
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas) return; // The wheel scrolls the page until the picture has been clicked.
    event.preventDefault();
    zoom(Math.exp(Math.sign(event.deltaY) * Math.min(0.2, Math.abs(event.deltaY) / 500)));
  }, { passive: false });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("pointerdown", (event) => {
    if (event.isTrusted) canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    if (fingers.size === 0) travelled = 0;
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const [x, y] = [event.clientX - before[0], event.clientY - before[1]];
    travelled += Math.hypot(x, y);
    const others = [...fingers].filter(([id]) => id !== event.pointerId).map(([, spot]) => spot);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (others.length) {
      const apart = ([a, b]) => Math.hypot(a - others[0][0], b - others[0][1]) || 1;
      zoom(apart(before) / apart([event.clientX, event.clientY]));
      move(x / canvas.clientHeight, y / canvas.clientHeight);
    } else (event.buttons & 2 || event.shiftKey || state.top ? move : turn)(2 * x / canvas.clientHeight, 2 * y / canvas.clientHeight);
  });
  const lift = (event) => {
    const was = fingers.delete(event.pointerId);
    if (!was || event.type !== "pointerup" || event.button !== 0 || fingers.size || travelled > 6) return;
    const box = canvas.getBoundingClientRect();
    read(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
  };
  for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, lift);
  window.addEventListener("resize", redraw);

  find(".colors").style.background = `linear-gradient(to right, ${about.colors.map((color) => `rgb(${color})`).join(", ")})`;
  view.hidden = false;
  show(0);
  cut(1);
})();
