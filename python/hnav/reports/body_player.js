// The body that turns over a run: what body.js draws, at the time of a slider.
const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
const body = JSON.parse(document.getElementById("body-data").textContent), t = new Float32Array(bytes(body.t));
const unpacked = track => ({ ...track, q: new Int16Array(bytes(track.q)) });
const tracks = body.tracks.map(unpacked), truth = body.truth && unpacked(body.truth);
const slider = document.getElementById("body-time"), button = document.getElementById("body-play");
const chooser = document.getElementById("body-filter"), speed = document.getElementById("body-speed");
let at = 0, playing = 0;
frame = body.frame;
const attitude = (track, i) => Array.from(track.q.subarray(4 * i, 4 * i + 4), part => part / body.unit);

function paint() {
  clear();
  const track = tracks[chooser ? chooser.value : 0], q = attitude(track, at), ink = onScreen("#333333");
  if (known(q)) paintNose(q, onScreen(track.colour), ink);
  if (truth && known(attitude(truth, at))) paintBox(attitude(truth, at), ink, false);
  label(t[at], q);
}

function turnTo(i) {
  at = Math.max(0, Math.min(t.length - 1, i));
  slider.value = at;
  paint();
}
// The figures show the time of the body, and the body the time at which a figure points (cursor.js).
function show(i) {
  turnTo(i);
  pointAt(t[at]);
}
document.addEventListener("point", event => playing || turnTo(t.findIndex(time => time >= event.detail)));
function play(now) {
  if (!playing) return;
  const until = playing.t + (now - playing.now) / 1000 * Number(playing.speed);
  let i = at;
  while (i < t.length - 1 && t[i + 1] <= until) ++i;
  if (i !== at) show(i);
  if (at === t.length - 1) stop(); else requestAnimationFrame(play);
}
function stop() {
  playing = 0;
  button.textContent = "play";
}
function start() {
  if (at === t.length - 1) at = 0;
  playing = { t: t[at], now: performance.now(), speed: speed.value };
  button.textContent = "stop";
  requestAnimationFrame(play);
}
button.addEventListener("click", () => (playing ? stop() : start()));
speed.addEventListener("change", () => playing && start());
slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
if (chooser) chooser.addEventListener("change", paint);
// The first moment shows nothing: the middle of the run does.
show(Math.floor(t.length / 2));
