"""A client of the hub over OPC UA, made with asyncua: `client.py URL WHAT …` prints a line for each step."""

import asyncio
import math
import sys
import time
from pathlib import Path

from asyncua import Client, ua
from asyncua.common.events import Event
from asyncua.crypto.cert_gen import setup_self_signed_certificate
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
from asyncua.ua.uaerrors import UaStatusCodeError
from cryptography.x509.oid import ExtendedKeyUsageOID

PATIENCE = 20.0
NAMESPACE = "urn:lafet:hub"
NAN = math.nan


def say(*words):
    print(*words, flush=True)


async def until(what, wanted):
    end = time.monotonic() + PATIENCE
    while True:
        value = await wanted()
        if value:
            return value
        assert time.monotonic() < end, what
        await asyncio.sleep(0.02)


class Hub:
    """A session, with its methods by their names."""

    def __init__(self, client):
        self.client, self.ticket, self.task = client, 0, None

    async def open(self):
        self.space = await self.client.get_namespace_index(NAMESPACE)
        return self

    def id(self, text):
        return ua.NodeId(text, self.space)

    def node(self, text):
        return self.client.get_node(self.id(text))

    async def call(self, owner, method, *inputs):
        """The status of a call, and what it returns."""
        request = ua.CallMethodRequest()
        request.ObjectId, request.MethodId = owner, method
        request.InputArguments = list(inputs)
        result = (await self.client.uaclient.call([request]))[0]
        outputs = [it.Value if isinstance(it, ua.Variant) else it for it in result.OutputArguments]
        return result.StatusCode, outputs

    async def ask(self, name, *inputs, monitor="M1"):
        inputs = [ua.Variant(value, kind) for value, kind in inputs]
        owner = self.id(monitor)
        return await self.call(owner, self.id(f"{monitor}.{name}"), *inputs)

    async def tell(self, name, *inputs, monitor="M1"):
        """Calls a method with a ticket; prints what has come of it."""
        ticket = (self.ticket, ua.VariantType.UInt64)
        self.say(name, *await self.ask(name, ticket, *inputs, monitor=monitor))

    def say(self, name, status, outputs):
        if outputs and outputs[0]:
            say(name, "ok" if status.is_good() else status.name)
        else:
            by = outputs[3] if len(outputs) > 3 else ""
            say(name, outputs[1] if len(outputs) > 1 else "-", status.name, by)

    async def alive(self):
        site = self.id("$site")
        ticket = ua.Variant(self.ticket, ua.VariantType.UInt64)
        status, (self.ticket, live) = await self.call(site, self.id("$site.Alive"), ticket)
        assert status.is_good()
        return live

    async def live(self):
        """Shows from now on that it is alive."""

        async def forever():
            while True:
                await self.alive()
                await asyncio.sleep(0.5)

        self.task = asyncio.create_task(forever())
        await until("it is live", self.alive)

    async def fresh(self):
        """A ticket that is later than what came before."""
        await asyncio.sleep(0.2)
        await self.alive()

    async def key(self):
        _, outputs = await self.ask("GetKey")
        return outputs[0]

    async def value(self, text):
        return await self.node(text).read_data_value(raise_on_bad_status=False)


def double(value):
    return (float(value), ua.VariantType.Double)


async def move(hub, traverse, elevation=NAN, nozzle=NAN):
    await hub.tell("Move", double(traverse), double(elevation), double(nozzle))


async def opened(hub, key, valve=1):
    await hub.tell("Open", (key, ua.VariantType.UInt64), (valve, ua.VariantType.UInt16))


async def until_value(hub, text, wanted):
    async def is_it():
        value = await hub.value(text)
        return value.StatusCode.is_good() and wanted(value.Value.Value)

    await until(text, is_it)


async def browse(hub):
    site = hub.node("$site")
    say("site", (await site.read_browse_name()).Name)
    names = [(await it.read_browse_name()).Name for it in await site.get_children()]
    say("children", *sorted(set(names)))
    found = await hub.client.nodes.objects.get_child([f"{hub.space}:Lafet", f"{hub.space}:M1"])
    say("found", found.nodeid.Identifier)
    kind = await hub.client.get_node(await hub.node("M1.Traverse").read_type_definition()).read_browse_name()
    say("type", kind.Name)
    units = await hub.node("M1.Traverse.Position.EngineeringUnits").read_value()
    spread = await hub.node("M1.Traverse.Position.EURange").read_value()
    say("unit", units.UnitId, units.DisplayName.Text, spread.Low, spread.High)
    inputs = await hub.node("M1.Move.InputArguments").read_value()
    say("inputs", *[it.Name for it in inputs])
    value = await hub.value("M1.Traverse.Position")
    say("position", value.StatusCode.name, round(value.Value.Value, 2))
    say("absent", (await hub.value("M1.Valve2.Open")).StatusCode.name)
    age = (time.time() - value.SourceTimestamp.timestamp())
    say("stamped", abs(age) < 5)
    try:
        await hub.node("M1.Traverse.Position").write_value(1.0)
    except UaStatusCodeError as error:
        say("write", type(error).__name__)


class Seen:
    def __init__(self):
        self.values, self.events = {}, []

    def datachange_notification(self, node, _, data):
        value = data.monitored_item.Value
        self.values.setdefault(node.nodeid.Identifier, []).append(value)

    def event_notification(self, event: Event):
        self.events.append((time.monotonic(), event))

    async def until(self, text, wanted):
        async def is_it():
            return any(wanted(it) for it in self.values.get(text, []))

        await until(text, is_it)


async def subscribe(hub):
    seen = Seen()
    subscription = await hub.client.create_subscription(50, seen)
    names = ["M1.Traverse.Position", "M1.Age", "M1.Connected", "M1.Water.Flowing"]
    await subscription.subscribe_data_change([hub.node(it) for it in names])
    await seen.until("M1.Traverse.Position", lambda it: it.StatusCode.is_good())
    say("subscribed")
    bad = lambda it: not it.StatusCode.is_good() and it.Value.Value is None
    await seen.until("M1.Traverse.Position", bad)
    last = seen.values["M1.Traverse.Position"][-1]
    say("stale", last.StatusCode.name, last.SourceTimestamp is not None)
    uncertain = lambda it: it.StatusCode.name.startswith("Uncertain") and it.Value.Value is True
    await seen.until("M1.Water.Flowing", uncertain)
    say("water may flow")


async def session(hub):
    """All that a client does in its turn."""
    hub.say("early", *await hub.ask("Take", (0, ua.VariantType.UInt64)))
    await hub.live()
    await move(hub, 5)
    await hub.tell("Take")
    await until_value(hub, "M1.Authority.Holder", bool)
    await move(hub, 5, 10)
    await until_value(hub, "M1.Traverse.Position", lambda it: abs(it - 5) < 0.1)
    say("arrived")
    await opened(hub, 1)
    key = await hub.key()
    await opened(hub, key)
    await until_value(hub, "M1.Valve1.Open", bool)
    say("opened")
    await opened(hub, key)
    await hub.tell("Stow")
    hub.say("Close", *await hub.ask("Close", (0, ua.VariantType.UInt16)))
    await until_value(hub, "M1.Valve1.Closed", bool)
    hub.say("Stop", *await hub.ask("Stop"))
    await move(hub, 6)
    await hub.fresh()
    await move(hub, 6)
    await hub.tell("Release")
    say("done")


async def refused(hub):
    """What a client without rights may do."""
    await hub.live()
    await hub.tell("Take")
    await move(hub, 5)
    await opened(hub, 1)
    hub.say("Stop", *await hub.ask("Stop"))
    hub.say("Lockout", *await hub.ask("Lockout"))
    status, _ = await hub.ask("GetKey")
    say("GetKey", status.name)
    say("done")


async def hold(hub, target, opens):
    """Takes authority, moves and opens, and goes on until its input ends."""
    await hub.live()
    await hub.tell("Take")
    if opens == "open":
        await opened(hub, await hub.key())
        await until_value(hub, "M1.Valve1.Open", bool)
    await move(hub, float(target))
    say("moving")
    line = await asyncio.to_thread(sys.stdin.readline)
    if line.strip() == "silent":
        hub.task.cancel()
        say("silent")
        await asyncio.to_thread(sys.stdin.readline)
    elif line.strip() == "die":
        import os

        os._exit(1)


FIELDS = ["EventId", "EventType", "SourceName", "Time", "Message", "Severity", "ConditionName", "Retain"]


def conditions(filtered):
    """The fields of an alarm, as standard clients ask for them."""
    clause = lambda path, kind=ua.ObjectIds.BaseEventType: ua.SimpleAttributeOperand(
        TypeDefinitionId=ua.NodeId(kind),
        BrowsePath=[ua.QualifiedName(it) for it in path],
        AttributeId=ua.AttributeIds.Value if path else ua.AttributeIds.NodeId,
    )
    kind = ua.ObjectIds.AlarmConditionType
    filtered.SelectClauses = [clause([it]) for it in FIELDS[:6]]
    filtered.SelectClauses += [clause([it], ua.ObjectIds.ConditionType) for it in FIELDS[6:]]
    filtered.SelectClauses += [clause(["ActiveState", "Id"], kind), clause(["AckedState", "Id"], kind)]
    filtered.SelectClauses += [clause(["Comment"], ua.ObjectIds.ConditionType)]
    filtered.SelectClauses += [clause([], ua.ObjectIds.ConditionType)]
    filtered.SelectClauses += [clause(["ShelvingState", "CurrentState", "Id"], kind)]
    return filtered


class Alarm:
    def __init__(self, fields):
        values = [it.Value for it in fields]
        self.id, self.kind, self.source = values[0], values[1], values[2]
        self.message, self.severity, self.name, self.retain = values[4], values[5], values[6], values[7]
        self.active, self.acked = values[8], values[9]
        self.comment, self.condition, self.shelved = values[10], values[11], values[12]


class Listener:
    """A subscription to alarms, on the wire."""

    def __init__(self, hub):
        self.hub, self.alarms = hub, []

    async def open(self):
        self.subscription = await self.hub.client.create_subscription(50, self)
        request = ua.MonitoredItemCreateRequest()
        request.ItemToMonitor.NodeId = ua.NodeId(ua.ObjectIds.Server)
        request.ItemToMonitor.AttributeId = ua.AttributeIds.EventNotifier
        request.MonitoringMode = ua.MonitoringMode.Reporting
        request.RequestedParameters = ua.MonitoringParameters()
        request.RequestedParameters.ClientHandle = 77
        request.RequestedParameters.QueueSize = 100
        request.RequestedParameters.Filter = conditions(ua.EventFilter())
        parameters = ua.CreateMonitoredItemsParameters()
        parameters.SubscriptionId = self.subscription.subscription_id
        parameters.ItemsToCreate = [request]
        parameters.TimestampsToReturn = ua.TimestampsToReturn.Both
        results = await self.hub.client.uaclient.create_monitored_items(parameters)
        results[0].StatusCode.check()
        publish = self.subscription.publish_callback

        def heard(result):
            for notification in result.NotificationMessage.NotificationData or []:
                if isinstance(notification, ua.EventNotificationList):
                    at = time.monotonic()
                    for event in notification.Events:
                        self.alarms.append((at, Alarm(event.EventFields)))
            return None

        async def callback(result):
            heard(result)

        self.hub.client.uaclient._subscription_callbacks[self.subscription.subscription_id] = callback
        return self

    async def until(self, what, wanted):
        async def is_it():
            return next((it for it in self.alarms if wanted(it[1])), None)

        return await until(what, is_it)


async def alarms(hub):
    """An alarm of the silence of M2: it is seen, acknowledged and shelved."""
    listener = await Listener(hub).open()
    say("listening")
    await asyncio.to_thread(sys.stdin.readline)
    _, alarm = await listener.until("an alarm", lambda it: it.source == "M2" and it.active)
    say("alarm", alarm.name, alarm.acked, alarm.retain, alarm.kind == ua.NodeId(ua.ObjectIds.AlarmConditionType))
    acknowledge, comment = ua.NodeId(9111), ua.Variant(ua.LocalizedText("seen by asyncua", "en"))
    wrong = ua.Variant(b"x", ua.VariantType.ByteString)
    status, _ = await hub.call(alarm.condition, acknowledge, wrong, comment)
    say("wrong", status.name)
    began = time.monotonic()
    status, _ = await hub.call(alarm.condition, acknowledge, ua.Variant(alarm.id, ua.VariantType.ByteString), comment)
    answered = time.monotonic()
    at, acked = await listener.until("it is acknowledged", lambda it: it.name == alarm.name and it.acked)
    say("acknowledge", status.name, acked.comment.Text)
    say("took", round(1000 * (answered - began)), round(1000 * (at - began)))
    status, _ = await hub.call(alarm.condition, acknowledge, ua.Variant(acked.id, ua.VariantType.ByteString), comment)
    say("again", status.name)
    count = len(listener.alarms)
    subscription = ua.Variant(listener.subscription.subscription_id, ua.VariantType.UInt32)
    status, _ = await hub.call(ua.NodeId(ua.ObjectIds.ConditionType), ua.NodeId(3875), subscription)
    await until("they are sent once more", lambda: asyncio.sleep(0, len(listener.alarms) >= count + 3))
    kinds = [it.kind.Identifier for _, it in listener.alarms[count:]]
    say("refresh", status.name, kinds[0] == 2787, 2788 in kinds, alarm.name in [it.name for _, it in listener.alarms[count:]])
    status, _ = await hub.call(alarm.condition, ua.NodeId(2949), ua.Variant(120000.0, ua.VariantType.Double))
    await listener.until("it is shelved", lambda it: it.name == alarm.name and it.shelved and it.shelved.Identifier == 2932)
    say("shelve", status.name)
    status, _ = await hub.call(alarm.condition, ua.NodeId(2947))
    say("unshelve", status.name)


async def history(hub):
    from datetime import datetime, timedelta, timezone

    await hub.live()
    await hub.tell("Take")
    await move(hub, 40)
    await until_value(hub, "M1.Traverse.Position", lambda it: abs(it - 40) < 0.1)
    await asyncio.sleep(1.5)
    now = datetime.now(timezone.utc)
    node = hub.node("M1.Traverse.Position")
    values = await node.read_raw_history(now - timedelta(minutes=5), now + timedelta(minutes=1))
    good = [it.Value.Value for it in values if it.StatusCode.is_good()]
    times = [it.SourceTimestamp for it in values]
    say("history", len(good) >= 3, times == sorted(times), any(abs(it - 40) < 0.2 for it in good))
    some = await node.read_raw_history(now - timedelta(minutes=5), now + timedelta(minutes=1), numvalues=2)
    say("two", len(some))


async def flood(hub, items, seconds):
    """Values per second that come to a subscription, and the longest time of a Stop meanwhile, ms."""
    count = 0

    class Counter:
        def datachange_notification(self, *_):
            nonlocal count
            count += 1

    subscription = await hub.client.create_subscription(50, Counter())
    ages = [hub.node("M1.Age")] * int(items)
    for at in range(0, len(ages), 500):
        await subscription.subscribe_data_change(ages[at : at + 500], queuesize=10)
    await asyncio.sleep(1)
    count, slowest = 0, 0.0
    began = time.monotonic()
    while time.monotonic() < began + float(seconds):
        asked = time.monotonic()
        await hub.ask("Stop")
        slowest = max(slowest, time.monotonic() - asked)
        await asyncio.sleep(0.2)
    say("values", round(count / (time.monotonic() - began)), "stop", round(1000 * slowest))


async def tries(url, user, password):
    client = Client(url)
    client.set_user(user)
    client.set_password(password)
    try:
        async with client:
            say("connected")
    except Exception as error:
        say("refused", type(error).__name__)


async def secure(url, folder, user, password, what):
    """With a certificate of its own, in a folder."""
    cert, key = Path(folder) / "client.der", Path(folder) / "client.pem"
    uri = "urn:lafet:test:client"
    await setup_self_signed_certificate(
        key, cert, uri, "localhost", [ExtendedKeyUsageOID.CLIENT_AUTH], {"commonName": "lafet test"}
    )
    client = Client(url)
    client.application_uri = uri
    client.set_user(user)
    client.set_password(password)
    await client.set_security(SecurityPolicyBasic256Sha256, str(cert), str(key))
    try:
        async with client:
            await globals()[what](await Hub(client).open())
    except UaStatusCodeError as error:
        say("refused", type(error).__name__)


async def main(url, what, *arguments):
    if what in ("tries", "secure"):
        return await globals()[what](url, *arguments)
    async with Client(url, timeout=10) as client:
        await globals()[what](await Hub(client).open(), *arguments)


asyncio.run(main(*sys.argv[1:]))
