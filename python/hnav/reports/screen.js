// The colours and sizes of the screen.
const dark = matchMedia("(prefers-color-scheme: dark)");
// What is ink on paper is light on a dark screen; the hues stay what they are.
const ON_DARK = {
  "#222222": "#ededed", "#333333": "#d4d4d4", "#8A8A8A": "#9a9a9a", "#E8E8E8": "#34373b", "#D0D0D0": "#4a4e53", "#B0B0B0": "#777b80",
  "#B8B8B8": "#888c91", "#0072B2": "#3fa2e0", "#009E73": "#1dc096", "#F3E9DC": "#3b342b",
  "rgba(0,114,178,": "rgba(63,162,224,", "rgba(255,255,255,0.9)": "rgba(32,34,37,0.9)"
};
const onScreen = text => dark.matches ? Object.entries(ON_DARK).reduce((said, [from, to]) => said.replaceAll(from, to), text) : text;
const scale = () => parseFloat(getComputedStyle(document.documentElement).fontSize) / 15;
