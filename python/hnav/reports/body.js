// A body on a canvas. screen.js has the colours and sizes of the screen; who draws sets frame, paints, and defines paint().
const canvas = document.getElementById("body-canvas"), says = document.getElementById("body-says");
const FLOOR = -0.75, c = canvas.getContext("2d");
let azimuth = -0.6, elevation = 0.45, size = 1, frame = "ned";

// Vectors of the page are east, north, up.
const toEnu = v => frame === "enu" ? v : [v[1], v[0], -v[2]];
function turned(q, v) {
  const [w, x, y, z] = q, [a, b, c] = v;
  const p = 2 * (y * c - z * b), r = 2 * (z * a - x * c), s = 2 * (x * b - y * a);
  return toEnu([a + w * p + y * s - z * r, b + w * r + z * p - x * s, c + w * s + x * r - y * p]);
}
const known = q => q.some(value => value !== 0);

const HALF = [1, 0.62, 0.16];
const CORNERS = [0, 1, 2, 3, 4, 5, 6, 7].map(i => HALF.map((h, k) => (i >> k & 1 ? h : -h)));
const FACES = [[1, 3, 7, 5], [0, 4, 6, 2], [2, 6, 7, 3], [0, 1, 5, 4], [4, 5, 7, 6], [0, 2, 3, 1]];
const SHADES = [1, 0.55, 0.7, 0.7, 0.85, 0.6];

// How the world is seen: to the right, upwards, and towards who looks, in units of the body's half length.
function seen([e, n, u]) {
  const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  return [ca * e + sa * n, u * ce + (ca * n - sa * e) * se, u * se - (ca * n - sa * e) * ce];
}

function path(points, closed) {
  c.beginPath();
  points.forEach((v, i) => {
    const [x, y] = seen(v);
    if (i) c.lineTo(size * x, -size * y); else c.moveTo(size * x, -size * y);
  });
  if (closed) c.closePath();
}

function paintFloor() {
  c.lineWidth = scale();
  c.strokeStyle = onScreen("#D0D0D0");
  for (const radius of [0.7, 1.4]) {
    path([...Array(73).keys()].map(i => [radius * Math.cos(i * Math.PI / 36), radius * Math.sin(i * Math.PI / 36), FLOOR]), true);
    c.stroke();
  }
  c.font = `${13 * scale()}px system-ui, sans-serif`;
  c.textAlign = "center";
  c.textBaseline = "middle";
  for (const [name, e, n] of [["N", 0, 1], ["E", 1, 0], ["S", 0, -1], ["W", -1, 0]]) {
    path([[0, 0, FLOOR], [1.4 * e, 1.4 * n, FLOOR]]);
    c.stroke();
    const [x, y] = seen([1.55 * e, 1.55 * n, FLOOR]);
    c.fillStyle = name === "N" ? "#D55E00" : onScreen("#333333");
    c.fillText(name, size * x, -size * y);
  }
}

function paintNose(q, colour, ink) {
  const nose = turned(q, [1, 0, 0]);
  c.strokeStyle = colour;
  c.lineWidth = 3 * scale();
  c.globalAlpha = 0.45;
  path([[0, 0, FLOOR], [1.1 * nose[0], 1.1 * nose[1], FLOOR]]);
  c.stroke();
  c.globalAlpha = 1;
  paintBox(q, colour, true);
  c.lineWidth = 2.4 * scale();
  c.strokeStyle = ink;
  path([nose, turned(q, [1.55, 0, 0])]);
  c.stroke();
  path([[1.35, 0.12, 0], [1.55, 0, 0], [1.35, -0.12, 0]].map(v => turned(q, v)));
  c.stroke();
}

function paintBox(q, colour, filled) {
  const corners = CORNERS.map(v => turned(q, v)), card = getComputedStyle(document.documentElement).getPropertyValue("--card");
  const faces = FACES.map((face, i) => ({ face, i, near: face.reduce((sum, k) => sum + seen(corners[k])[2], 0) }));
  faces.sort((a, b) => a.near - b.near);
  c.lineWidth = (filled ? 1 : 1.4) * scale();
  c.setLineDash(filled ? [] : [5 * scale(), 4 * scale()]);
  c.strokeStyle = filled ? card : colour;
  for (const { face, i } of faces) {
    path(face.map(k => corners[k]), true);
    // The card below the colour hides the faces behind.
    for (const [style, alpha] of filled ? [[card, 1], [colour, SHADES[i]]] : []) {
      c.fillStyle = style;
      c.globalAlpha = alpha;
      c.fill();
    }
    c.globalAlpha = 1;
    c.stroke();
  }
  c.setLineDash([]);
}

// An empty canvas with the floor, as large as the page has it.
function clear() {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  size = Math.min(width / 3.4, height / 3.05);
  c.scale(ratio, ratio);
  c.translate(width / 2, height / 2 - 0.03 * size);
  paintFloor();
}

function label(t, q) {
  let angles = "no attitude yet";
  if (known(q)) {
    const [w, x, y, z] = q, degrees = 180 / Math.PI;
    const roll = degrees * Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y));
    const pitch = degrees * Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x))));
    const nose = turned(q, [1, 0, 0]), heading = (degrees * Math.atan2(nose[0], nose[1]) + 360) % 360;
    angles = `roll ${roll.toFixed(1)}°  pitch ${pitch.toFixed(1)}°  heading ${heading.toFixed(1)}°`;
  }
  says.textContent = `${t.toFixed(2)} s   ${angles}`;
}

let from = null;
canvas.addEventListener("pointerdown", event => { from = event; canvas.setPointerCapture(event.pointerId); });
canvas.addEventListener("pointermove", event => {
  if (!from) return;
  azimuth -= (event.clientX - from.clientX) / 150;
  elevation = Math.max(-1.5, Math.min(1.5, elevation + (event.clientY - from.clientY) / 150));
  from = event;
  paint();
});
canvas.addEventListener("pointerup", () => { from = null; });
dark.addEventListener("change", paint);
addEventListener("resize", paint);
