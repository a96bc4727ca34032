"""What people see and do on the page of --view and of columba view."""

import json
import signal
import subprocess
from contextlib import contextmanager

from chromium import address_in, browser, open_page, until  # noqa: F401 (fixtures)
from conftest import free_port
from ground import GUIDED, LOITER, RTL
from plans import FENCE, Uploader, item
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from test_station import field, start_fly, told  # noqa: F401

FLOCK = "(() => columba.stage.flock.n === {})()"


def wait_for_vehicles(page, count):
    until(page, FLOCK.format(count))
    until(page, "columba.stage.frames > 2 && columba.player.status !== null")


@contextmanager
def viewed_run(program, folder, *options):
    """A flight by the clock: the address of its page."""
    words = [program, "run", "--speed", "1", "--view", "--no-report", "--out", folder, "--vehicle-port", "0", *options]
    run = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    try:
        yield address_in(run.stderr.readline())
    finally:
        run.kill()
        run.wait()


@contextmanager
def viewer(program, *words):
    """`columba view`: the address of its page. It ends well when it is told to."""
    view = subprocess.Popen([program, "view", *words], stderr=subprocess.PIPE, text=True)
    try:
        yield address_in(view.stderr.readline())
    finally:
        view.send_signal(signal.SIGINT)
        assert view.wait(timeout=30) == 0


def test_a_vehicle_that_leaves_guided_raises_an_alarm_that_leads_to_it(open_page, start_vehicles, scenario):
    vehicles = start_vehicles(scenario(count=5), "--speed", 5, "--view")
    page = open_page(address_in(vehicles.errors).replace("#", "?webgl#"))
    wait_for_vehicles(page, 5)
    assert page.evaluate("columba.stage.painter.name") == "WebGL 2"
    page.wait_for_selector(".row >> nth=4")
    fourth = vehicles.connect()[3]
    fourth.link.mav.set_mode_send(fourth.system, 1, RTL)
    page.click("#tab-alarms")
    page.click("#now button:has-text('vehicle 4')")
    # The alarm selects the vehicle, and what is known of it says what happened.
    page.wait_for_selector("#selected-name:has-text('Vehicle 4')")
    page.wait_for_selector("#selected-events:has-text('left GUIDED to RTL')")
    page.wait_for_selector("#charts .uplot")
    page.click("#tab-vehicles")
    page.fill("#filter", "alarm")
    until(page, "document.querySelectorAll('.row').length === 1")
    assert page.inner_text(".row").split()[:2] == ["4", "RTL"]
    page.fill("#filter", "")
    page.click("[data-sort=separation]")
    page.click("[data-sort=separation]")
    page.wait_for_selector("[aria-sort=descending] [data-sort=separation]")
    # Seen from the side, and pausing the picture does not pause the flight.
    page.click("#view-3d")
    page.click("#play")
    paused = page.evaluate("columba.player.now")
    until(page, f"columba.player.end > {paused} + 1")
    assert page.evaluate("columba.player.now") == paused
    page.click("#live")
    until(page, f"columba.player.now > {paused} + 1")


def test_a_narrow_page_without_webgl_has_all_of_it(open_page, start_vehicles, scenario):
    vehicles = start_vehicles(scenario(count=3), "--view")
    address = address_in(vehicles.errors).replace("#", "?canvas#")
    page = open_page(address, width=360, height=740, color_scheme="dark", has_touch=True)
    wait_for_vehicles(page, 3)
    assert page.evaluate("columba.stage.painter.name") == "canvas"
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    # On a slow machine the vehicles have left the first picture by now.
    project = "columba.stage.camera.project(...['x', 'y', 'z'].map(name => columba.stage.flock[name][0]))"
    place = page.evaluate(f"(() => {{ columba.stage.fit(); return {project}; }})()")
    box = page.locator("#stage").bounding_box()
    assert 0 < place[0] < box["width"] and 0 < place[1] < box["height"], "the vehicle is in the picture"


#: How many pixels of the picture have each vehicle's colour within a few pixels of where the camera says that it is;
#: and how many have it at all. A picture is read in the same turn in which it was drawn.
PAINTED = """(() => {
  const { stage } = columba, { flock, camera, canvas } = stage;
  stage.isStale = true;
  stage.draw(performance.now());
  const ahead = stage.player.ahead(performance.now());
  const copy = Object.assign(document.createElement('canvas'), { width: canvas.width, height: canvas.height });
  const context = copy.getContext('2d');
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, copy.width, copy.height);
  const is = (at, colour) => [0, 8, 16].every((shift, k) => Math.abs(data[at + k] - ((colour >> shift) & 255)) < 8);
  const near = [];
  for (let i = 0; i < flock.n; i++) {
    const on = flock.speed[i] * ahead;
    const [north, east] = [Math.cos(flock.course[i]) * on, Math.sin(flock.course[i]) * on];
    const [px, py] = camera.project(flock.x[i] + north, flock.y[i] + east, flock.z[i]);
    let count = 0;
    for (let y = Math.round(py) - 8; y <= py + 8; y++) {
      for (let x = Math.round(px) - 8; x <= px + 8; x++) if (is(4 * (y * copy.width + x), flock.colour[i])) count++;
    }
    near.push(count);
  }
  let all = 0;
  for (let at = 0; at < data.length; at += 4) if (is(at, flock.colour[0])) all++;
  return { near, all };
})()"""


def test_both_painters_put_each_vehicle_where_the_camera_says(open_page, start_vehicles, scenario):
    vehicles = start_vehicles(scenario(count=5), "--view")
    painted = {}
    for name in ("webgl", "canvas"):
        page = open_page(address_in(vehicles.errors).replace("#", f"?{name}#"))
        wait_for_vehicles(page, 5)
        # They stand still, and in the picture.
        page.evaluate("columba.player.toggle()")
        page.click("#fit")
        for seen in ("from above", "from the side"):
            painted[name, seen] = page.evaluate(PAINTED)
            page.click("#view-3d")
    for seen in ("from above", "from the side"):
        webgl, canvas = painted["webgl", seen], painted["canvas", seen]
        # A vehicle of nine pixels covers about 150.
        assert min(webgl["near"]) > 60 and min(canvas["near"]) > 60, painted
        assert webgl["all"] < 1500 and canvas["all"] < 1500, "and nothing else has its colour"


def test_the_operator_aborts_in_two_steps_and_it_is_in_the_record(open_page, start_fly, start_vehicles, field):
    port, scenario = free_port(), field(count=2, duration_s=300)
    vehicles = start_vehicles(scenario, "--speed", 3, ground_port=port)
    controller = start_fly(scenario, "--speed", 3, "--link", f"udpin:127.0.0.1:{port}", "--view")
    address = address_in(controller.wait_for("live view: "))
    watcher = open_page(address.split("#")[0])
    page = open_page(address)
    page.wait_for_selector("#phase:has-text('fly')")
    second = vehicles.connect()[1]
    page.wait_for_selector(".row >> nth=1")
    page.click(".row >> nth=1")
    page.click("#tab-selected")
    # One alone holds, and flies on with the others.
    page.click("#orders-one [data-verb='pause N']")
    second.wait(["HEARTBEAT"], lambda message: second.is_ours(message) and message.custom_mode == LOITER, patience_s=60)
    page.wait_for_selector("#answer:has-text('pause 2')")
    assert page.inner_text("#phase") == "fly", "the others fly on"
    page.click("#orders-one [data-verb='resume N']")
    second.wait(["HEARTBEAT"], lambda message: second.is_ours(message) and message.custom_mode == GUIDED, patience_s=60)
    page.click("#orders-one [data-verb='drop N']")
    assert not told_of_drop(page), "the first step does nothing"
    page.click("dialog [data-say='drop N']")
    second.wait(["HEARTBEAT"], lambda message: second.is_ours(message) and message.custom_mode == LOITER, patience_s=60)
    until(page, "columba.events.some((event) => event.text.includes('dropped by the operator'))")
    # Whoever has no token can only watch: the button, and whoever speaks past it.
    watcher.wait_for_selector("#orders [data-verb=abort]:disabled")
    forged = """new Promise((done) => {
      const socket = new WebSocket(`ws://${location.host}/live`);
      socket.onopen = () => socket.send(JSON.stringify({ token: '', say: 'abort', id: 1 }));
      socket.onmessage = ({ data }) => typeof data === 'string' && data.includes('answer') && done(data);
    })"""
    assert "refused" in watcher.evaluate(forged)
    page.click("#orders [data-verb=abort]")
    page.click("dialog [data-say='abort loiter']")
    run = controller.end()
    assert run.status == 1 and "aborted by the operator" in run.errors
    assert told(run, "the operator says abort loiter (on the page, 127.0.0.1:")
    assert told(run, "the operator says pause 2 (on the page, 127.0.0.1:")
    assert told(run, "the page refused requests: 1 without the token")


def told_of_drop(page):
    return page.evaluate("columba.events.some((event) => event.text.includes('dropped'))")


def test_what_the_optimiser_had_to_choose_from_is_shown_of_any_moment(open_page, program, tmp_path):
    with viewed_run(program, tmp_path / "run") as address:
        page = open_page(address)
        wait_for_vehicles(page, 5)
        page.click(".row >> nth=2")
        page.click("#tab-selected")
        page.wait_for_selector("#choice h3:has-text('MSLPIO chose at')")
        until(page, "columba.choices.shown()?.at_s > 4")
        assert page.evaluate("columba.stage.follows && columba.stage.camera.shows(columba.stage.placeOf(2))")
        # Other members of the front can be looked at by the keyboard, and their weights are said; the next choice of
        # the flight takes no focus away.
        page.focus("#choice")
        focused_s = page.evaluate("columba.choices.shown().at_s")
        until(page, f"columba.choices.drawn?.at_s > {focused_s}")
        assert page.evaluate("document.activeElement.id === 'choice'")
        page.evaluate("columba.player.toggle()")
        page.keyboard.press("ArrowRight")
        page.wait_for_selector("#choice .note:has-text('hosen: formation')")
        # What was chosen before the vehicle was selected is remembered, too.
        page.evaluate("columba.player.seek(2.2)")
        until(page, "columba.choices.shown()?.at_s === 2")
        page.wait_for_selector("#choice h3:has-text('MSLPIO chose at 2.0 s')")
        off_m = (
            "(() => { const c = columba.choices.shown(), [x, y] = c.members[c.chosen].path_m[0];"
            " return Math.hypot(x - columba.stage.flock.x[2], y - columba.stage.flock.y[2]); })()"
        )
        assert page.evaluate(off_m) < 8, "its way begins where it was"


def test_what_does_not_change_has_its_charts_too(open_page, program, tmp_path):
    """Vehicles that stay at their starts while a slow link is measured: values that differ by a rounding error."""
    with viewed_run(program, tmp_path / "run", "--set", "link.delay_ms=1000") as address:
        page = open_page(address)
        wait_for_vehicles(page, 5)
        page.click(".row >> nth=2")
        page.click("#tab-selected")
        page.wait_for_selector(".uplot >> nth=2")
        # The page of before drew lines without end, and said so some seconds later.
        page.wait_for_timeout(8000)


def test_fences_and_missions_are_in_the_picture(open_page, start_vehicles, scenario, program):
    port = free_port()
    vehicles = start_vehicles(scenario(count=2), "--view", ground_port=port)
    first = vehicles.connect()[0]
    corners = [(-500, -500), (-500, 500), (500, 500), (500, -500)]
    stay_in = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
    fence = [item(stay_in, north, east, 0, p1=4) for north, east in corners]
    assert Uploader(first.link, first.system, FENCE).upload(fence) == mavlink.MAV_MISSION_ACCEPTED
    mission = [item(mavlink.MAV_CMD_NAV_WAYPOINT, north) for north in (0, 100, 200)]
    assert Uploader(first.link, first.system).upload(mission) == mavlink.MAV_MISSION_ACCEPTED
    with viewer(program, "--plans", "--link", f"udpin:127.0.0.1:{port}") as viewed:
        lines = "columba.stage.scene.outlines.filter((line) => line.kind === '{}').map((line) => line.points_m)"
        # The program knows the plans of its own vehicles, and another one asks for them.
        for address in (address_in(vehicles.errors), viewed):
            page = open_page(address)
            wait_for_vehicles(page, 2)
            until(
                page,
                f"{lines.format('fence')}.length === 1 && {lines.format('mission')}.some((way) => way.length === 3)",
            )
            way = page.evaluate(f"{lines.format('mission')}.find((way) => way.length === 3)")
            assert abs(way[2][0] - way[0][0] - 200) < 1 and abs(way[2][2] - 60) < 0.1
            assert len(page.evaluate(lines.format("fence"))[0]) == 4
            until(page, f"{lines.format('home')}.length > 0")


def test_a_log_is_played_back_and_scrubbed(open_page, flown, program):
    with viewer(program, flown.tlog) as address:
        page = open_page(address)
        wait = "columba.player.isRecording && columba.player.end > 41 && columba.stage.flock.n === 5"
        until(page, wait)
        page.wait_for_selector("#least-separation:has-text('least separation')")
        # The log has positions ten times a second, the judge of the flight saw every step.
        least = float(page.inner_text("#least-separation").split()[2])
        assert abs(least - flown.summary["min_separation_m"]) < 0.5
        page.evaluate("columba.player.toggle(); columba.player.seek(20)")
        until(page, "Math.abs(columba.stage.flock.x[0] - 190) < 60")
        page.click("#forth")
        assert 20 < page.evaluate("columba.player.now") < 20.2
        page.click("#least-separation")
        at_s = float(page.inner_text("#least-separation").split(", at ")[1].split()[0])
        assert abs(page.evaluate("columba.player.now") - at_s) < 0.1
        assert page.evaluate("columba.stage.selected.size") == 2


def test_the_replay_of_a_report_is_the_same_page_without_a_network(open_page, flown):
    page = open_page(f"file://{flown.folder}/report.html")
    until(page, "frames.length === 1")
    replay = page.frames[1]
    until(replay, "window.columba?.player.isRecording && columba.stage.flock.n === 5")
    assert not replay.evaluate("columba.player.isPlaying")
    replay.click("#play")
    until(replay, "columba.player.now > 1")
    replay.click("#view-3d")
    until(replay, "columba.stage.camera.is3d")
    least = f"{flown.summary['min_separation_m']:.2f} m"
    assert least in replay.inner_text("#least-separation")


def test_watching_changes_no_byte_of_a_flight(fly, flown):
    watched = fly("run", "--seed", 7, "--view")
    assert watched.status == 0 and "live view: http://127.0.0.1:" in watched.errors
    assert watched.trajectory_bytes == flown.trajectory_bytes


def test_any_vehicles_are_shown_without_configuration(open_page, start_vehicles, scenario, program):
    port = free_port()
    with viewer(program, "--link", f"udpin:127.0.0.1:{port}") as address:
        start_vehicles(scenario(count=2), "--personality", "px4", ground_port=port)
        page = open_page(address)
        wait_for_vehicles(page, 2)
        until(page, "Number.isFinite(columba.stage.flock.x[1])")
        assert json.loads(page.evaluate("JSON.stringify(columba.roster.systems)")) == [1, 2]


def test_simulated_vehicles_are_told_to_end_and_answer(open_page, start_vehicles, scenario):
    vehicles = start_vehicles(scenario(count=3), "--view")
    page = open_page(address_in(vehicles.errors))
    wait_for_vehicles(page, 3)
    second, third = vehicles.connect()[1:]
    page.click(".row >> nth=1")
    page.click("#tab-selected")
    page.click("#orders-one [data-verb='abort N']")
    page.click("dialog [data-say='return N']")
    page.wait_for_selector("#answer:has-text('return 2: accepted')")
    second.wait(["HEARTBEAT"], lambda message: second.is_ours(message) and message.custom_mode == RTL)
    said = "text.includes('the operator says return 2 (on the page, 127.0.0.1:')"
    until(page, f"columba.events.some(({{text, vehicles}}) => {said} && vehicles[0] === 2)")
    page.click("#orders [data-verb=abort]")
    page.click("dialog [data-say='abort loiter']")
    page.wait_for_selector("#answer:has-text('abort loiter: 3 of 3 have accepted')")
    third.wait(["HEARTBEAT"], lambda message: third.is_ours(message) and message.custom_mode == LOITER)
    # The orders to a selected vehicle stay when the scene is told again, or the right to give orders only now.
    page.evaluate("import('/page.js').then(({ hear }) => hear({ may: true }))")
    page.wait_for_selector("#orders-one [data-verb='abort N']:enabled")
    # Whoever has no token can only watch.
    watcher = open_page(address_in(vehicles.errors).split("#")[0])
    watcher.wait_for_selector("#orders [data-verb=abort]:disabled")
