// The page of hnav live: each message of the websocket is the newest state, with
// t_s, q (scalar first, or null), frame, heading_deg, sigma_deg, ready, health, rates, counts, notes, age_ms; of the INS also
// phase, place (latitude and longitude in deg, height in m, sigmas north, east, down in m, or null), velocity (north, east, down, or null).
const KEPT_S = 30, GAP_S = 1, RETRY_MS = 1000, MARGIN = { left: 54, right: 12, top: 10, bottom: 30 };
const headingCanvas = document.getElementById("heading-canvas"), lost = document.getElementById("lost");
let state = null, history = [], waiting = false;

function paint() {
  waiting = false;
  clear();
  if (!state) return;
  frame = state.frame;
  if (state.q) paintNose(state.q, onScreen("#0072B2"), onScreen("#333333"));
  label(state.t_s, state.q || [0, 0, 0, 0]);
  paintHeading();
  listState();
}

// Headings without jumps: each within half a turn of the one before.
function remember(s) {
  if (s.heading_deg === null) return;
  const before = history.at(-1);
  if (before && s.t_s <= before.t) { if (s.t_s < before.t) history = []; else return; }
  const near = before ? before.value + ((s.heading_deg - before.value + 540) % 360 + 360) % 360 - 180 : s.heading_deg;
  history.push({ t: s.t_s, value: near, sigma: s.sigma_deg[2] });
  while (history[0].t < s.t_s - KEPT_S) history.shift();
}

function paintHeading() {
  const g = headingCanvas.getContext("2d"), ratio = devicePixelRatio || 1, k = scale();
  const width = headingCanvas.clientWidth, height = headingCanvas.clientHeight;
  headingCanvas.width = width * ratio;
  headingCanvas.height = height * ratio;
  g.scale(ratio, ratio);
  if (!history.length) return;
  const end = history.at(-1).t, begin = end - KEPT_S, points = onAxis(history);
  const values = points.flatMap(p => [p.value - Math.min(p.sigma, 180), p.value + Math.min(p.sigma, 180)]);
  const middle = (Math.min(...values) + Math.max(...values)) / 2, half = Math.max(1, 0.55 * (Math.max(...values) - Math.min(...values)));
  const left = MARGIN.left * k, right = width - MARGIN.right * k, top = MARGIN.top * k, bottom = height - MARGIN.bottom * k;
  const x = t => left + (t - begin) / KEPT_S * (right - left), y = v => (top + bottom) / 2 - (v - middle) / half * (bottom - top) / 2;
  g.font = `${12 * k}px system-ui, sans-serif`;
  g.strokeStyle = onScreen("#E8E8E8");
  g.fillStyle = onScreen("#333333");
  g.textBaseline = "middle";
  g.textAlign = "right";
  const step = [0.5, 1, 2, 5, 10, 30, 45, 90, 180, 360].find(s => 2 * half / s <= 5) || 720;
  for (let v = Math.ceil((middle - half) / step) * step; v <= middle + half; v += step) {
    g.beginPath(); g.moveTo(left, y(v)); g.lineTo(right, y(v)); g.stroke();
    g.fillText(`${+(((v % 360) + 360) % 360).toFixed(1)}°`, left - 8 * k, y(v));
  }
  g.textAlign = "center";
  g.textBaseline = "alphabetic";
  for (let t = Math.ceil(begin / 10) * 10; t <= end; t += 10) g.fillText(`${t} s`, x(t), height - 8 * k);
  g.save();
  g.beginPath(); g.rect(left, top, right - left, bottom - top); g.clip();
  for (const part of partsOf(points)) {
    g.beginPath();
    part.forEach(p => g.lineTo(x(p.t), y(p.value + p.sigma)));
    part.slice().reverse().forEach(p => g.lineTo(x(p.t), y(p.value - p.sigma)));
    g.fillStyle = onScreen("rgba(0,114,178,") + "0.2)";
    g.fill();
    g.beginPath();
    part.forEach(p => g.lineTo(x(p.t), y(p.value)));
    g.strokeStyle = onScreen("#0072B2");
    g.lineWidth = 1.6 * k;
    g.stroke();
  }
  g.restore();
}

// More than one turn does not stay readable: then headings lie between 0 and 360 deg, and the line breaks at north.
function onAxis(points) {
  const values = points.map(p => p.value);
  if (Math.max(...values) - Math.min(...values) < 360) return points;
  return points.map(p => ({ ...p, value: ((p.value % 360) + 360) % 360 }));
}

// Stretches without a gap and without a jump at north.
function partsOf(points) {
  const parts = [];
  points.forEach((p, i) => {
    const before = points[i - 1];
    if (i && p.t - before.t < GAP_S && Math.abs(p.value - before.value) < 180) parts.at(-1).push(p); else parts.push([p]);
  });
  return parts;
}

function listState() {
  const rows = [
    ...Object.entries(state.ready).map(([name, is]) => [`${name} ready`, is ? "yes" : "no", is]),
    ...(state.phase ? placeRows() : []),
    ["sigma about north, east, down", state.sigma_deg ? state.sigma_deg.map(v => `${v.toFixed(2)}°`).join("  ") : "–", true],
    ...Object.entries(state.health).map(([name, is]) => [name, `${is}, ${state.rates[name].toFixed(0)} Hz`, is === "ok"]),
    ["age of the newest row", `${state.age_ms.toFixed(1)} ms`, true],
  ];
  document.getElementById("state-rows").innerHTML = "";
  for (const [name, said, good] of rows) {
    const row = document.getElementById("state-rows").insertRow();
    row.insertCell().textContent = name;
    const cell = row.insertCell();
    cell.textContent = said;
    if (!good) cell.style.color = "#D55E00";
  }
  const counts = document.getElementById("count-rows");
  counts.replaceChildren(...Object.entries(state.counts).map(([name, n]) => {
    const box = document.createElement("div"), head = document.createElement("dt"), value = document.createElement("dd");
    head.textContent = name;
    value.textContent = n;
    box.append(head, value);
    return box;
  }));
  document.getElementById("notes").textContent = state.notes.join("\n");
}

function placeRows() {
  const metres = values => values.map(v => v.toFixed(2)).join("  ");
  return [
    ["phase", state.phase, state.phase === "navigating"],
    ["latitude, longitude, height", state.place ? `${state.place[0].toFixed(7)}°  ${state.place[1].toFixed(7)}°  ${state.place[2].toFixed(2)} m` : "–", true],
    ["sigma north, east, down", state.place ? `${metres(state.place.slice(3))} m` : "–", true],
    ["velocity north, east, down", state.velocity ? `${metres(state.velocity)} m/s` : "–", true],
  ];
}

function connect() {
  const socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/state`);
  socket.onmessage = event => {
    state = JSON.parse(event.data);
    remember(state);
    lost.hidden = !state.stalled;
    lost.textContent = state.stalled ? `no line for ${state.stalled.toFixed(0)} s` : "";
    if (!waiting) { waiting = true; requestAnimationFrame(paint); }
  };
  socket.onclose = () => {
    lost.hidden = false;
    lost.textContent = "hnav live has ended, or cannot be reached";
    setTimeout(connect, RETRY_MS);
  };
}
paint();
connect();
