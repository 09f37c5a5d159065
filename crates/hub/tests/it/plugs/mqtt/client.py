"""A client of the hub over MQTT, made with paho-mqtt: `client.py PORT WHAT …` prints a line for each step."""

import json
import sys
import threading
import time

import paho.mqtt.client as mqtt

PATIENCE = 20.0
MONITOR = "lafet/M1"


class Client:
    def __init__(self, port):
        self.news = threading.Condition()
        self.seen, self.results, self.ids = {}, {}, 0
        self.alive = True
        self.mqtt = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, protocol=mqtt.MQTTv5)
        self.mqtt.on_connect = lambda *_: self.mqtt.subscribe("lafet/#", qos=1)
        self.mqtt.on_message = self.heard
        self.mqtt.connect("127.0.0.1", port)
        self.mqtt.loop_start()
        self.until("a ticket", lambda: "lafet/ticket" in self.seen and MONITOR + "/key" in self.seen)
        threading.Thread(target=self.live, daemon=True).start()

    def heard(self, _client, _data, message):
        with self.news:
            try:
                value = json.loads(message.payload)
            except ValueError:
                value = message.payload.decode(errors="replace")
            self.seen[message.topic] = value
            if message.topic == MONITOR + "/result":
                self.results.setdefault(value["id"], []).append(value)
            self.news.notify_all()

    def until(self, what, wanted):
        with self.news:
            assert self.news.wait_for(wanted, PATIENCE), what

    def live(self):
        while True:
            if self.alive:
                text = json.dumps({"ticket": self.seen["lafet/ticket"]["ticket"]})
                self.mqtt.publish("lafet/alive", text, qos=1)
            time.sleep(0.5)

    def send(self, command, **more):
        """Sends a command and waits for its result; returns its text too."""
        self.ids += 1
        text = {"id": f"paho-{id(self)}-{self.ids}", "command": command}
        text |= {"ticket": self.seen["lafet/ticket"]["ticket"], "timeout_ms": 20000, **more}
        payload = json.dumps(text)
        self.mqtt.publish(MONITOR + "/command", payload, qos=1)
        self.until(command, lambda: text["id"] in self.results)
        return self.results[text["id"]][0], payload

    def say(self, name, result):
        print(name, "ok" if result["ok"] else result["refusal"], flush=True)

    def key(self):
        return self.seen[MONITOR + "/key"]["key"]

    def state(self):
        return self.seen.get(MONITOR + "/state", {})


def session(client):
    """Takes authority, turns, opens, and shows that the same opening is no second one."""
    client.say("early", client.send("goto", traverse=1)[0])
    client.say("take", client.send("take")[0])
    client.say("goto", client.send("goto", traverse=10, elevation=5)[0])
    client.until("it arrives", lambda: (client.state().get("traverse"), client.state().get("elevation")) == (10, 5))
    print("arrived", flush=True)
    key = client.key()
    result, payload = client.send("open", valve=1, key=key)
    client.say("open", result)
    client.until("it is open", lambda: (client.state().get("valves") or {}).get("valve1", {}).get("open"))
    print("opened", flush=True)
    client.until("another key", lambda: client.key() != key)
    client.mqtt.publish(MONITOR + "/command", payload, qos=1)
    client.until("the first result again", lambda: len(client.results[result["id"]]) == 2)
    print("again", client.results[result["id"]][1]["repeated"], flush=True)
    client.say("old key", client.send("open", valve=1, key=key)[0])
    client.say("stow", client.send("stow")[0])
    client.say("close", client.send("close")[0])
    client.until("it is closed", lambda: (client.state().get("valves") or {}).get("valve1", {}).get("closed"))
    client.say("stop", client.send("stop")[0])
    client.say("release", client.send("release")[0])
    print("done", flush=True)


def hold(client, what):
    """Holds authority with a motion under way or a valve open, until a line of its input makes it silent."""
    client.say("take", client.send("take")[0])
    if what == "open":
        client.say("open", client.send("open", valve=1, key=client.key())[0])
    else:
        client.say("goto", client.send("goto", traverse=int(what))[0])
    for line in sys.stdin:
        if line.strip() == "silent":
            client.alive = False
            print("silent", flush=True)


def flood(client):
    """Commands as quick as they go."""
    print("floods", flush=True)
    number = 0
    while True:
        number += 1
        text = json.dumps({"id": f"f{number}", "command": "goto", "traverse": 3, "ticket": "0" * 16})
        client.mqtt.publish(MONITOR + "/command", text, qos=0)
        if number % 50 == 0:
            time.sleep(0.01)


CLIENT = Client(int(sys.argv[1]))
{"session": session, "hold": hold, "flood": flood}[sys.argv[2]](CLIENT, *sys.argv[3:])
