// A client of the hub over OPC UA, made with node-opcua: `client.cjs URL FOLDER USER PASSWORD` prints a line for each step.
// With a user the channel is signed and encrypted.

const {
  AttributeIds,
  ClientMonitoredItem,
  ClientSubscription,
  DataType,
  MessageSecurityMode,
  OPCUACertificateManager,
  OPCUAClient,
  SecurityPolicy,
  TimestampsToReturn,
  UserTokenType,
  Variant,
  constructEventFilter,
} = require("node-opcua-client");

const PATIENCE = 20_000;
const say = (...words) => console.log(words.join(" "));
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

async function until(what, wanted) {
  const end = Date.now() + PATIENCE;
  for (;;) {
    const value = await wanted();
    if (value) return value;
    if (Date.now() > end) throw new Error(what);
    await pause(20);
  }
}

const FIELDS = ["EventId", "SourceName", "ConditionName", "Retain", "ActiveState.Id", "AckedState.Id", "Comment"];

async function alarms(session, subscription) {
  const heard = [];
  const item = ClientMonitoredItem.create(
    subscription,
    { nodeId: "i=2253", attributeId: AttributeIds.EventNotifier },
    { filter: constructEventFilter(FIELDS), queueSize: 100, discardOldest: true },
    TimestampsToReturn.Both,
  );
  item.on("err", (why) => say("item", why));
  item.on("changed", (fields) => heard.push(fields.map((it) => it.value)));
  await new Promise((done) => item.once("initialized", done));
  say("listening");
  await new Promise((done) => process.stdin.once("data", done));
  const has = (acked) => () =>
    heard.find(([, source, , , active, is]) => source === "M2" && active && is === acked);
  const [event, source, name] = await until("an alarm", has(false));
  say("alarm", source, name);
  const condition = `ns=${session.space};s=$alarm:${name}`;
  const status = await session.acknowledgeCondition(condition, event, "seen by node-opcua");
  const acked = await until("it is acknowledged", has(true));
  say("acknowledge", status.name, acked[6].text);
}

async function main(url, folder, user, password) {
  const manager = new OPCUACertificateManager({ rootFolder: folder, automaticallyAcceptUnknownCertificate: true });
  await manager.initialize();
  const client = OPCUAClient.create({
    applicationName: "lafet test",
    clientCertificateManager: manager,
    connectionStrategy: { maxRetry: 0 },
    endpointMustExist: false,
    securityMode: user ? MessageSecurityMode.SignAndEncrypt : MessageSecurityMode.None,
    securityPolicy: user ? SecurityPolicy.Aes256_Sha256_RsaPss : SecurityPolicy.None,
  });
  try {
    await client.connect(url);
  } catch (error) {
    say("refused", /\bBad\w+/.exec(error.message)?.[0] ?? error.message);
    process.exit(0);
  }
  const who = user ? { type: UserTokenType.UserName, userName: user, password } : undefined;
  const session = await client.createSession(who);
  session.space = (await session.readNamespaceArray()).indexOf("urn:lafet:hub");
  const id = (text) => `ns=${session.space};s=${text}`;
  const found = await session.browse("i=85");
  say("objects", found.references.map((it) => it.browseName.name).includes("Lafet"));
  const value = await session.read({ nodeId: id("M1.Traverse.Position"), attributeId: AttributeIds.Value });
  say("position", value.statusCode.name, DataType[value.value.dataType]);
  const subscription = ClientSubscription.create(session, {
    requestedPublishingInterval: 50,
    requestedLifetimeCount: 1000,
    requestedMaxKeepAliveCount: 10,
    publishingEnabled: true,
  });
  const ages = new Set();
  const item = ClientMonitoredItem.create(
    subscription,
    { nodeId: id("M1.Connected"), attributeId: AttributeIds.Value },
    { samplingInterval: 50, queueSize: 10 },
    TimestampsToReturn.Both,
  );
  item.on("changed", (it) => ages.add(`${it.statusCode.name} ${it.value.value}`));
  await until("a value", () => ages.has("Good true"));
  say("subscribed");
  await alarms(session, subscription);
  const call = async (name, ...inputs) => {
    const inputArguments = inputs.map(([dataType, value]) => new Variant({ dataType, value }));
    const methodId = id(`M1.${name}`);
    const result = await session.call({ objectId: id("M1"), methodId, inputArguments });
    say(name, result.statusCode.name, result.outputArguments?.[3]?.value || "-");
  };
  await call("Take", [DataType.UInt64, [0, 0]]);
  await call("Stop");
  await call("Close", [DataType.UInt16, 0]);
  await session.close();
  await client.disconnect();
  say("done");
  process.exit(0);
}

main(...process.argv.slice(2)).catch((error) => {
  say("failed", error.stack);
  process.exit(1);
});
