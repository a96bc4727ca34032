"""Fetches the parameters of many vehicles as good ground stations do: the list, then by index what did not come."""

import time

# After so long without anything new the lists are taken to be over; an answer that has not come by then is asked for
# again.
QUIET_S = 0.3
# Questions under way at a time.
WINDOW = 400


class Lists:
    """Of the vehicles of some system ids, all behind one pymavlink connection; `found` has each one's values by
    index."""

    def __init__(self, link, systems):
        self.link = link
        self.found = {system: {} for system in systems}
        self.counts = {}
        self.requests = 0

    def fetch(self, patience_s=120):
        """Gives the seconds that it took."""
        start = heard = time.monotonic()
        for system in self.found:
            self.ask(system, None)
        asked = {}
        while missing := self.missing():
            now = time.monotonic()
            assert now - start < patience_s, f"{len(missing)} missing after {patience_s} s, {self.requests} requests"
            if now - heard > QUIET_S or asked:
                asked = self.ask_again(missing, asked, now)
            # Reading is cheaper than looking for what is missing.
            for _ in range(WINDOW):
                message = self.link.recv_match(type="PARAM_VALUE", blocking=True, timeout=QUIET_S / 10)
                if message is None:
                    break
                if self.take(message):
                    heard = time.monotonic()
        return time.monotonic() - start

    def missing(self):
        unknown = [(system, None) for system in self.found if system not in self.counts]
        known = [
            (system, index)
            for system, count in self.counts.items()
            if len(self.found[system]) < count
            for index in range(count)
            if index not in self.found[system]
        ]
        return unknown + known

    def take(self, message):
        """Whether it is new."""
        system, index = message.get_srcSystem(), message.param_index
        if system not in self.found or index >= message.param_count or index in self.found[system]:
            return False
        self.counts[system] = message.param_count
        self.found[system][index] = message
        return True

    def ask_again(self, missing, asked, now):
        """Fills the window; gives what is asked, and when."""
        asked = {key: at for key, at in asked.items() if now - at < QUIET_S and key in missing[: 2 * WINDOW]}
        for key in missing:
            if len(asked) >= WINDOW:
                break
            if key not in asked:
                self.ask(*key)
                asked[key] = now
        return asked

    def ask(self, system, index):
        self.requests += 1
        self.link.target_system = system
        if index is None:
            self.link.mav.param_request_list_send(system, 1)
        else:
            self.link.mav.param_request_read_send(system, 1, b"", index)
