// The connection to the program: a live flight, or a recording that it reads.

import { Moment, momentsOf } from "./wire.js";
import { begin, hear, player, playOn, setConnection, setLook, setSay } from "./page.js";

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
    begin();
    setConnection("live", false);
    look();
    if (token) socket.send(JSON.stringify({ token }));
  };
  socket.onmessage = ({ data }) => {
    if (typeof data !== "string") {
      if (player.isRecording) playOn(momentsOf(data));
      else player.take(new Moment(data), performance.now());
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

connect();
