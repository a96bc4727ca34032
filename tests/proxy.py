"""A bad network: a UDP proxy between vehicles and their controller that loses datagrams."""

import random
import selectors
import socket
import threading


def loopback(port=0):
    bound = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    bound.bind(("127.0.0.1", port))
    bound.setblocking(False)
    return bound


class LossyProxy:
    """Vehicles send to `port`; the controller at `ground_port` meets each of them at a port of its own.

    `loss` is the share of datagrams lost each way, drawn with `seed`.
    """

    def __init__(self, ground_port, loss, seed=1):
        self.ground = ("127.0.0.1", ground_port)
        self.loss, self.random = loss, random.Random(seed)
        self.front = loopback()
        self.port = self.front.getsockname()[1]
        self.backs = {}  # by vehicle's address
        self.passed = self.lost = 0
        self.selector = selectors.DefaultSelector()
        self.selector.register(self.front, selectors.EVENT_READ, None)
        self.stopping = threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.stopping.set()
        self.thread.join()
        for key in list(self.selector.get_map().values()):
            key.fileobj.close()
        self.selector.close()

    def run(self):
        while not self.stopping.is_set():
            for key, _ in self.selector.select(timeout=0.1):
                try:
                    datagram, sender = key.fileobj.recvfrom(65_536)
                except OSError:  # a port that answered a datagram of ours with "unreachable"
                    continue
                if key.data is None:
                    self.forward(self.back(sender), datagram, self.ground)
                else:
                    self.forward(self.front, datagram, key.data)

    def back(self, vehicle):
        """The socket at which the controller meets a vehicle."""
        if vehicle not in self.backs:
            self.backs[vehicle] = loopback()
            self.selector.register(self.backs[vehicle], selectors.EVENT_READ, vehicle)
        return self.backs[vehicle]

    def forward(self, link, datagram, to):
        if self.random.random() < self.loss:
            self.lost += 1
            return
        self.passed += 1
        try:
            link.sendto(datagram, to)
        except OSError:  # as above
            pass
