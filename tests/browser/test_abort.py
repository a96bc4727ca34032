"""How long an abort on the page takes to reach the vehicles, over real UDP."""

import time

import pytest
from chromium import address_in, browser, open_page  # noqa: F401 (fixtures)
from conftest import free_port
from proxy import LossyProxy
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from test_station import field, start_fly, told  # noqa: F401

CONTROL_PERIOD_S = 0.5
VEHICLES = 5


#: By the clock that this process has too: the page is on the same machine.
NOTES_WHEN_IT_IS_SAID = """(() => {
  const { send } = WebSocket.prototype;
  WebSocket.prototype.send = function (words) {
    if (words.includes('abort')) window.saidAt = Date.now();
    return send.call(this, words);
  };
})()"""


class Tap(LossyProxy):
    """Passes everything on, and keeps what the controller sends to each vehicle, and when."""

    def __init__(self, ground_port):
        super().__init__(ground_port, loss=0.0)
        self.sent = []

    def forward(self, link, datagram, to):
        if link is self.front:
            self.sent.append((time.time(), to, datagram))
        super().forward(link, datagram, to)

    def messages(self, since):
        """When, to which vehicle, and what was sent since a moment."""
        parsers = {}
        for at, to, datagram in self.sent:
            if at < since:
                continue
            parser = parsers.setdefault(to, mavlink.MAVLink(None))
            parser.robust_parsing = True
            for message in parser.parse_buffer(datagram) or []:
                yield at - since, to, message


def ends(message):
    """Whether a message is of the end of a flight: another mode."""
    return message.get_type() == "SET_MODE" or getattr(message, "command", None) == mavlink.MAV_CMD_DO_SET_MODE


@pytest.mark.parametrize("personality", ["generic", "arduplane"])
def test_an_abort_reaches_all_vehicles_within_a_control_period(
    open_page,
    start_fly,
    start_vehicles,
    field,
    personality,
):
    port, scenario = free_port(), field(count=VEHICLES, duration_s=300)
    with Tap(port) as tap:
        start_vehicles(scenario, "--personality", personality, ground_port=tap.port)
        controller = start_fly(scenario, "--link", f"udpin:127.0.0.1:{port}", "--view")
        page = open_page(address_in(controller.wait_for("live view: ")))
        page.wait_for_selector("#phase:has-text('fly')")
        page.click("#orders [data-verb=abort]")
        page.evaluate(NOTES_WHEN_IT_IS_SAID)
        page.click("dialog [data-say='abort loiter']")
        since = page.evaluate("saidAt / 1000")
        run = controller.end()
    reached = {}
    for after_s, to, message in tap.messages(since):
        if ends(message):
            reached.setdefault(to, after_s)
    took_s = sorted(reached.values())
    times = ", ".join(f"{each:.3f}" for each in took_s)
    print(f"{personality}: an abort on the page reached {VEHICLES} vehicles after {times} s")
    # A busy machine may take as long again.
    assert len(took_s) == VEHICLES and took_s[-1] < 2 * CONTROL_PERIOD_S, took_s
    assert run.status == 1 and told(run, "the operator says abort loiter (on the page, 127.0.0.1:")
    ended = told(run, "is left in LOITER, and changes to ")
    # Planes that circle side by side do so at heights of their own.
    assert len({event["text"].rsplit(" to ", 1)[1] for event in ended}) == VEHICLES, run.errors
