// The connection to the program: a recording that it serves, or a live flight.

import { Moment } from "./wire.js";
import { forgetEvents, hear, play, player, setConnection, setLook, setSay } from "./page.js";

const token = location.hash.slice(1);
let socket = null;
let isOver = false;

setSay((words) => {
  if (socket?.readyState !== WebSocket.OPEN) return false;
  socket.send(JSON.stringify({ token, ...words }));
  return true;
});

// Anybody may look: no token goes with it.
let looksAt = null;
const look = () => { if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ look: looksAt })); };
setLook((number) => {
  looksAt = number;
  look();
});

function connect() {
  socket = new WebSocket(`ws://${location.host}/live`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => {
    forgetEvents();
    setConnection("live", false);
    look();
    if (token) socket.send(JSON.stringify({ token }));
  };
  socket.onmessage = ({ data }) => {
    if (typeof data !== "string") {
      player.take(new Moment(data), performance.now());
      return;
    }
    const message = JSON.parse(data);
    isOver = isOver || message.over === true;
    hear(message);
  };
  socket.onclose = () => {
    setConnection(isOver ? "the program has ended" : "the program is not there", true);
    if (player.newest) player.newest.rate = 0;
    // A program that has ended does not come back at this address, but one that was out of reach may.
    if (!isOver) setTimeout(connect, 1500);
  };
}

async function begin() {
  const head = await fetch("recording.json");
  if (head.status !== 200) return connect();
  const [known, frames] = await Promise.all([head.json(), fetch("recording.bin").then((answer) => answer.arrayBuffer())]);
  play(known, frames);
}

begin();
