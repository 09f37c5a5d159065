"""A host application of Sparkplug B, made with pysparkplug: `sparkplug_host.py PORT WHAT …` prints a line for each step."""

import json
import sys
import threading
import time

import pysparkplug as psp

PATIENCE = 20.0
GROUP, NODE, HOST = "site", "hub", "scada"


class Host:
    def __init__(self, port):
        self.news = threading.Condition()
        self.values, self.results, self.ids = {}, {}, 0
        self.births, self.seq, self.wrong = 0, None, []
        self.alive = True
        # That it has gone is said with the time at which it came: so the specification has it.
        self.since = psp.get_current_timestamp()
        self.client = psp.Client(client_id=HOST)
        self.client.set_will(self.state(False))
        everything = psp.Topic(group_id=GROUP, message_type=psp.MULTI_LEVEL_WILDCARD)
        self.client.subscribe(everything, psp.QoS.AT_LEAST_ONCE, self.heard)
        self.client.connect("127.0.0.1", port=port, callback=lambda _: self.is_here())
        threading.Thread(target=self.live, daemon=True).start()

    def state(self, online):
        topic = psp.Topic(message_type=psp.MessageType.STATE, sparkplug_host_id=HOST)
        payload = psp.State(timestamp=self.since, online=online)
        return psp.Message(topic=topic, payload=payload, qos=psp.QoS.AT_LEAST_ONCE, retain=True)

    def is_here(self):
        self.client.publish(self.state(True))

    def heard(self, _client, message):
        kind, device = str(message.topic.message_type), message.topic.device_id
        if kind in ("NCMD", "DCMD"):
            return
        payload = message.payload
        with self.news:
            self.check(kind, message)
            for metric in getattr(payload, "metrics", ()):
                if metric.is_historical:
                    value = None if metric.is_null else metric.value
                    print("past", device, metric.name, value, metric.timestamp, flush=True)
                    continue
                self.values[(device, metric.name)] = None if metric.is_null else metric.value
            names = {metric.name for metric in getattr(payload, "metrics", ())}
            if kind.endswith("DATA") and "Result/Number" in names:
                keys = ("Id", "Ok", "Refusal", "Repeated", "Text", "Monitor")
                result = {key: self.values.get((device, "Result/" + key)) for key in keys}
                self.results.setdefault(result["Id"], []).append(result)
            if kind == "NBIRTH":
                self.births += 1
                print("born", self.values[(None, "bdSeq")], flush=True)
            elif kind == "DBIRTH":
                print("born", device, flush=True)
            elif kind == "NDEATH":
                print("dead", payload.bd_seq_metric.value, flush=True)
            elif kind == "DDEATH":
                print("dead", device, flush=True)
            self.news.notify_all()

    def check(self, kind, message):
        """The sequence, and how it was sent."""
        expected = 1 if kind == "NDEATH" else 0
        if message.qos != expected or message.retain:
            print("wrong", kind, message.qos, message.retain, flush=True)
        if kind == "NDEATH":
            number, born = message.payload.bd_seq_metric.value, self.values.get((None, "bdSeq"))
            if number != born:
                print("wrong", kind, number, "after", born, flush=True)
            return
        seq = message.payload.seq
        if seq != (0 if kind == "NBIRTH" else (self.seq + 1) % 256):
            print("wrong", kind, seq, "after", self.seq, flush=True)
        self.seq = seq

    def until(self, what, wanted):
        with self.news:
            assert self.news.wait_for(wanted, PATIENCE), (what, self.values)

    def write(self, device, name, value):
        kind = psp.DataType.STRING if isinstance(value, str) else psp.DataType.BOOLEAN
        metric = psp.Metric(timestamp=psp.get_current_timestamp(), name=name, datatype=kind, value=value)
        of = psp.NCmd if device is None else psp.DCmd
        payload = of(timestamp=psp.get_current_timestamp(), metrics=(metric,))
        verb = psp.MessageType.NCMD if device is None else psp.MessageType.DCMD
        topic = psp.Topic(group_id=GROUP, message_type=verb, edge_node_id=NODE, device_id=device)
        message = psp.Message(topic=topic, payload=payload, qos=psp.QoS.AT_MOST_ONCE, retain=False)
        self.client.publish(message, include_dtypes=True)

    def live(self):
        while True:
            ticket = self.values.get((None, "Ticket"))
            if self.alive and ticket:
                self.write(None, "Alive", ticket)
            time.sleep(0.5)

    def value(self, name, device="M1"):
        return self.values.get((device, name))

    def send(self, command, device="M1", **more):
        """Sends a command and waits for its result; returns its text too."""
        self.ids += 1
        text = {"id": f"host-{id(self)}-{self.ids}", "command": command, "timeout_ms": 20000}
        text |= {"ticket": self.values[(None, "Ticket")], **more}
        payload = json.dumps(text)
        self.write(device, "Command/Text", payload)
        self.until(command, lambda: text["id"] in self.results)
        return self.results[text["id"]][0], payload

    def button(self, name, device="M1"):
        """Writes true to one metric, as a button of a screen does."""
        before = len(self.results.get(None, ()))
        self.write(device, name, True)
        self.until(name, lambda: len(self.results.get(None, ())) > before)
        return self.results[None][-1]

    def say(self, name, result):
        print(name, "ok" if result["Ok"] else result["Refusal"], flush=True)


def session(host):
    """Takes authority, turns, opens, and shows that the same opening is no second one."""
    host.until("a birth", lambda: host.value("Mode") and host.values.get((None, "Ticket")))
    host.say("early", host.send("goto", traverse=1)[0])
    host.say("take", host.send("take")[0])
    host.say("goto", host.send("goto", traverse=10, elevation=5)[0])
    host.until("it arrives", lambda: (host.value("Traverse"), host.value("Elevation")) == (10, 5))
    print("arrived", flush=True)
    key = host.value("Key")
    result, payload = host.send("open", valve=1, key=key)
    host.say("open", result)
    host.until("it is open", lambda: host.value("Valve 1/Open"))
    print("opened", flush=True)
    host.until("another key", lambda: host.value("Key") != key)
    host.write("M1", "Command/Text", payload)
    host.until("the first result again", lambda: len(host.results[result["Id"]]) == 2)
    print("again", host.results[result["Id"]][1]["Repeated"], flush=True)
    host.say("old key", host.send("open", valve=1, key=key)[0])
    host.say("close", host.button("Command/Close"))
    host.until("it is closed", lambda: host.value("Valve 1/Closed"))
    host.say("stop", host.button("Command/Stop"))
    host.say("stop all", host.button("Command/Stop", None))
    host.say("release", host.send("release")[0])
    host.say("not here", host.send("stop", "M9")[0])
    births = host.births
    for _ in range(3):
        host.write(None, "Node Control/Rebirth", True)
    host.until("births", lambda: host.births > births)
    print("done", host.births - births, flush=True)


def hold(host):
    """Is on its way to a position, until its input ends or it is killed."""
    host.until("a birth", lambda: host.value("Mode") and host.values.get((None, "Ticket")))
    host.say("take", host.send("take")[0])
    host.say("goto", host.send("goto", traverse=170)[0])
    sys.stdin.read()


def watch(_host):
    """Prints what it hears, until its input ends."""
    sys.stdin.read()


HERE = Host(int(sys.argv[1]))
{"session": session, "hold": hold, "watch": watch}[sys.argv[2]](HERE)
