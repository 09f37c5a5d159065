-- Structure of a frame, a record and its data; the tables above define the rest.

local SYNC, END, ESCAPE = 0xFF, 0xC0, 0xDB
local MONITOR_LAST, CONTROLLER = 127, 128
local INFO_RECORDS = 6

local lafet = Proto("lafet", T.protocol)
local records_only = Proto("lafet_records", T.protocol_records)

lafet.prefs.tcp_ports = Pref.range("TCP", PORTS, T.tcp_ports, 65535)
lafet.prefs.udp_ports = Pref.range("UDP", PORTS, T.udp_ports, 65535)

local f = {
  dst = ProtoField.uint8("lafet.dst", T.dst, base.DEC),
  src = ProtoField.uint8("lafet.src", T.src, base.DEC),
  kind = ProtoField.uint8("lafet.kind", T.kind, base.DEC, { [0] = T.probe, T.request, T.answer }),
  crc = ProtoField.uint16("lafet.crc", "CRC-16/MODBUS", base.HEX),
  crc32c = ProtoField.uint32("lafet.crc32c", "CRC-32C", base.HEX),
  noise = ProtoField.bytes("lafet.noise", T.noise),
  record = ProtoField.none("lafet.record", T.record),
  request = ProtoField.uint8("lafet.request", T.request, base.HEX, REQUESTS),
  device = ProtoField.uint8("lafet.device", T.device, base.HEX, SUBSYSTEMS),
  status = ProtoField.uint8("lafet.status", T.status, base.DEC, STATUSES),
  size = ProtoField.uint8("lafet.size", T.size, base.DEC),
  data = ProtoField.bytes("lafet.data", T.data),
}
local e = {
  crc = ProtoExpert.new("lafet.crc.bad", T.bad_crc, expert.group.CHECKSUM, expert.severity.ERROR),
  escape = ProtoExpert.new("lafet.escape.bad", T.bad_escape, expert.group.MALFORMED, expert.severity.ERROR),
  cut = ProtoExpert.new("lafet.record.cut", T.cut, expert.group.MALFORMED, expert.severity.ERROR),
  shape = ProtoExpert.new("lafet.data.shape", T.shape, expert.group.MALFORMED, expert.severity.WARN),
  refused = ProtoExpert.new("lafet.refused", T.refused, expert.group.RESPONSE_CODE, expert.severity.NOTE),
}

-- Fields of the data, by structure and name; flags, by class and name.
local all = {}
for _, field in pairs(f) do all[#all + 1] = field end

local make = {
  U8 = function(...) return ProtoField.uint8(...) end,
  I8 = function(...) return ProtoField.int8(...) end,
  U16 = function(...) return ProtoField.uint16(...) end,
  I16 = function(...) return ProtoField.int16(...) end,
  U32 = function(...) return ProtoField.uint32(...) end,
  I32 = function(...) return ProtoField.int32(...) end,
}
local SIZES = { U8 = 1, I8 = 1, U16 = 2, I16 = 2, U32 = 4, I32 = 4, Flags = 4, ParamId = 2, Key = 2 }

local function field_of(structure, spec)
  local abbr = "lafet." .. structure .. "." .. spec.name
  if spec.kind == "Flags" then
    return ProtoField.uint32(abbr, spec.text, base.HEX)
  elseif spec.kind == "ParamId" then
    return ProtoField.uint16(abbr, spec.text, base.HEX, PARAMS)
  elseif spec.kind == "Key" then
    return ProtoField.uint16(abbr, spec.text, base.HEX, KEYS)
  end
  local shown = spec.bits and base.HEX or base.DEC
  return make[spec.kind](abbr, spec.text, shown)
end

local function prepare(layout)
  layout.size, layout.step = 0, 0
  for _, spec in ipairs(layout.fields) do
    spec.field = field_of(layout.abbr, spec)
    spec.bytes = SIZES[spec.kind]
    layout.size = layout.size + spec.bytes
    all[#all + 1] = spec.field
  end
  for _, spec in ipairs(layout.repeated) do
    spec.field = field_of(layout.abbr, spec)
    spec.bytes = SIZES[spec.kind]
    layout.step = layout.step + spec.bytes
    all[#all + 1] = spec.field
  end
end
for _, layout in pairs(LAYOUTS) do prepare(layout) end

for _, class in pairs(FLAGS) do
  for _, flag in ipairs(class) do
    local abbr = "lafet." .. class.abbr .. "." .. flag.abbr
    if flag.width == 1 then
      flag.field = ProtoField.bool(abbr, flag.name, 32, nil, flag.mask, flag.text)
    else
      flag.field = ProtoField.uint32(abbr, flag.name, base.DEC, BUTTON_STATES, flag.mask, flag.text)
    end
    all[#all + 1] = flag.field
  end
end

lafet.fields = all
lafet.experts = { e.crc, e.escape, e.cut, e.shape, e.refused }

local function fits(layout, data)
  local rest = #data - layout.size
  local whole
  if layout.step == 0 then
    whole = rest == 0
  else
    local times = rest / layout.step
    whole = rest >= 0 and times == math.floor(times) and times >= layout.least and times <= layout.most
  end
  return whole and data:sub(1, #layout.prefix) == layout.prefix
end

local function layout_of(layouts, data)
  for _, name in ipairs(layouts or {}) do
    if fits(LAYOUTS[name], data) then return LAYOUTS[name] end
  end
end

local function add_flags(tree, range, device)
  local class = FLAGS[CLASSES[device]]
  for _, flag in ipairs(class or {}) do tree:add_le(flag.field, range) end
end

local function add_field(tree, spec, range, device)
  local item = tree:add_le(spec.field, range)
  if spec.unit then item:append_text(" " .. spec.unit) end
  if spec.kind == "Flags" then add_flags(item, range, device) end
end

local function add_data(tree, range, record)
  local answer = record.way == 2
  local layouts = answer and (ANSWERS[record.request] or STATES[record.device])
  if not answer then layouts = DATA[record.request] or { "Empty" } end
  if answer and record.request ~= GET_STATUS and not ANSWERS[record.request] then layouts = nil end
  local layout = layout_of(layouts, record.data)
  if not layout then
    local item = tree:add(f.data, range)
    -- A refusal has no data; data without a known layout can have any shape.
    if layouts then item:add_proto_expert_info(e.shape) end
    return
  end
  tree:append_text(", " .. layout.name)
  local at = 0
  for _, spec in ipairs(layout.fields) do
    add_field(tree, spec, range(at, spec.bytes), record.device)
    at = at + spec.bytes
  end
  while layout.step > 0 and at < #record.data do
    for _, spec in ipairs(layout.repeated) do
      add_field(tree, spec, range(at, spec.bytes), record.device)
      at = at + spec.bytes
    end
  end
end

local function name_of(names, value)
  return names[value] or string.format("0x%02x", value)
end

-- Name of a record. Few differ, so names are cached.
local titles = {}

local function title(way, request, device, status)
  local key = ((way * 256 + request) * 256 + device) * 256 + status
  local known = titles[key]
  if not known then
    known = name_of(SUBSYSTEMS, device) .. " " .. name_of(REQUESTS, request)
    if way == 2 then known = known .. " → " .. name_of(STATUSES, status) end
    titles[key] = known
  end
  return known
end

local function add_record(tree, range, record)
  local branch = tree:add(f.record, range)
  branch:set_text(title(record.way, record.request, record.device, record.status))
  branch:add(f.request, range(0, 1))
  branch:add(f.device, range(1, 1))
  local status = branch:add(f.status, range(2, 1))
  if record.way == 2 and REFUSALS[record.status] then status:add_proto_expert_info(e.refused) end
  branch:add(f.size, range(3, 1))
  if #record.data > 0 then add_data(branch, range(4), record) end
end

-- The records between two offsets of a frame, as a line of text.
local function summary(bytes, at, last, way)
  local line, count = nil, 0
  while at <= last do
    local request, device, status, size = bytes:byte(at, at + 3)
    if at + 3 > last or at + 3 + size > last then
      return line and line .. "; " .. T.cut or T.cut
    end
    count = count + 1
    if count <= INFO_RECORDS then
      local text = title(way, request, device, status)
      line = line and line .. "; " .. text or text
    end
    at = at + 4 + size
  end
  return count > INFO_RECORDS and line .. "; … (" .. count .. ")" or line
end

-- Adds the records of a payload to the tree.
local function add_records(bytes, tvb, way, tree)
  local at = 1
  while at <= #bytes do
    local request, device, status, size = bytes:byte(at, at + 3)
    if not size or at + 3 + size > #bytes then
      tree:add_proto_expert_info(e.cut)
      return
    end
    local record = { request = request, device = device, status = status, way = way }
    record.data = bytes:sub(at + 4, at + 3 + size)
    add_record(tree, tvb(at - 1, 4 + size), record)
    at = at + 4 + size
  end
end

-- Requests go to a monitor, answers come from it; the controller answers too, except for its grants.
local function way_of(dst, src, first)
  if src <= MONITOR_LAST then return 2 end
  if src == CONTROLLER and dst > CONTROLLER and first ~= ACCESS_GRANTED then return 2 end
  return 1
end

-- Lua 5.2 has a library for it, 5.3 and later have operators that 5.2 cannot read.
local xor = bit32 and bit32.bxor or load("return function(a, b) return a ~ b end")()

local function half(value, by)
  return math.floor((value - value % by) / by)
end

-- CRC of bytes with a reflected polynomial and the initial value `start`.
local function checker(polynomial, start)
  local step = {}
  for byte = 0, 255 do
    local crc = byte
    for _ = 1, 8 do
      local odd = crc % 2 == 1
      crc = half(crc, 2)
      if odd then crc = xor(crc, polynomial) end
    end
    step[byte] = crc
  end
  return function(bytes)
    local crc = start
    for i = 1, #bytes do
      crc = xor(half(crc, 256), step[xor(crc % 256, bytes:byte(i))])
    end
    return crc
  end
end

local crc16 = checker(0xA001, 0xFFFF)
local inverted = checker(0x82F63B78, 0xFFFFFFFF)
local function crc32c(bytes) return xor(inverted(bytes), 0xFFFFFFFF) end

local PLAIN = { ["\xDB\xDC"] = "\xC0", ["\xDB\xDD"] = "\xDB" }

-- Dissects one frame between its two C0. `shown`: whether the tree is displayed.
local function frame(wire, range, tree, shown)
  local long = wire:sub(1, 2) == "\xDB\xDE"
  if long then
    wire = wire:sub(3)
    range = range and range(2)
  end
  local body, tvb, broken = wire, range, false
  if wire:find("\xDB", 1, true) then
    body = wire:gsub("\xDB.?", function(pair)
      broken = broken or not PLAIN[pair]
      return PLAIN[pair]
    end)
    if shown then tvb = ByteArray.new(body, true):tvb(T.unescaped):range() end
  end
  local dst, src, first = body:byte(1, 3)
  local last = #body - (long and 4 or 2)
  local way = last > 2 and way_of(dst, src, first) or 0
  local text = way == 0 and T.probe or summary(body, 3, last, way)
  if shown then
    local branch = tree:add(lafet, range)
    branch:append_text(": " .. src .. " → " .. dst .. ", " .. text)
    branch:add(f.dst, tvb(0, 1))
    branch:add(f.src, tvb(1, 1))
    branch:add(f.kind, tvb(0, 2), way):set_generated()
    if way ~= 0 then add_records(body:sub(3, last), tvb(2, last - 2), way, branch) end
    local there = tvb(last, #body - last)
    local crc = branch:add_le(long and f.crc32c or f.crc, there)
    local right = (long and crc32c or crc16)(body:sub(1, last))
    if right ~= there:le_uint() then crc:add_proto_expert_info(e.crc) end
    if broken then branch:add_proto_expert_info(e.escape) end
  end
  return src .. " → " .. dst .. "  " .. text
end

local self

-- Cached text of a frame with one record, by addresses and header; bounded, as noise never repeats.
local SINGLES_MAX = 10000
local singles, kept = {}, 0

-- The line of a piece that is one frame of one record with nothing escaped, as most pieces are.
local function single(bytes)
  if #bytes < 11 or bytes:find("[\xC0\xDB]", 3) ~= #bytes then return end
  local head = bytes:sub(1, 8)
  local known = singles[head]
  if not known then
    local sync, start, dst, src, first, _, _, size = head:byte(1, 8)
    local text = summary(head, 5, 8 + size, way_of(dst, src, first))
    known = { size = sync == SYNC and start == END and 11 + size, info = src .. " → " .. dst .. "  " .. text }
    if kept == SINGLES_MAX then singles, kept = {}, 0 end
    singles[head], kept = known, kept + 1
  end
  return known.size == #bytes and known.info
end

-- The lines of whole pieces: polls are the same few pieces again and again.
local pieces, pieces_kept = {}, 0

local function line_of(bytes)
  local info = single(bytes)
  if info then
    if pieces_kept == SINGLES_MAX then pieces, pieces_kept = {}, 0 end
    pieces[bytes], pieces_kept = info, pieces_kept + 1
  end
  return info
end

local function name(pinfo, info)
  local cols = pinfo.cols
  cols.protocol = "lafet"
  cols.info = info
end

-- Dissects every frame in a piece of a stream; returns the offset of an unfinished frame, if any.
local function frames(bytes, shown, tvb, pinfo, tree)
  local infos, last = nil, 0
  local begin = bytes:find("\xC0", 1, true)
  while begin do
    local ending = bytes:find("\xC0", begin + 1, true)
    if not ending then break end
    if ending - begin > 4 then
      local first = begin > 1 and bytes:byte(begin - 1) == SYNC and begin - 1 or begin
      if shown and first - 1 > last then tree:add(f.noise, tvb(last, first - 1 - last)) end
      local range = shown and tvb(begin, ending - begin - 1)
      local info = frame(bytes:sub(begin + 1, ending - 1), range, tree, shown)
      infos = infos and infos .. " | " .. info or info
      last = ending
      begin = bytes:find("\xC0", ending + 1, true)
    else
      begin = ending
    end
  end
  if infos then name(pinfo, infos) end
  return begin and begin - 1
end

function lafet.dissector(tvb, pinfo, tree)
  local bytes = tvb:raw()
  -- What is visible counts as referenced.
  local shown = tree:referenced(self)
  local info = not shown and (pieces[bytes] or line_of(bytes))
  if info then
    name(pinfo, info)
    return #bytes
  end
  local open = frames(bytes, shown, tvb, pinfo, tree)
  if open and pinfo.can_desegment > 0 then
    pinfo.desegment_offset = open
    pinfo.desegment_len = DESEGMENT_ONE_MORE_SEGMENT
  end
  return #bytes
end

-- Bare records over TCP: what comes from a known port is an answer.
function records_only.dissector(tvb, pinfo, tree)
  local way = pinfo.src_port < pinfo.dst_port and 2 or 1
  local branch = tree:add(records_only, tvb())
  local bytes = tvb:raw()
  name(pinfo, summary(bytes, 1, #bytes, way))
  add_records(bytes, tvb(), way, branch)
  return tvb:len()
end

local tcp, udp = DissectorTable.get("tcp.port"), DissectorTable.get("udp.port")
local ports = {}

local function listen()
  if ports.tcp then
    tcp:remove(ports.tcp, lafet)
    udp:remove(ports.udp, lafet)
  end
  ports = { tcp = lafet.prefs.tcp_ports, udp = lafet.prefs.udp_ports }
  tcp:add(ports.tcp, lafet)
  udp:add(ports.udp, lafet)
end
lafet.prefs_changed = listen
listen()
tcp:add_for_decode_as(records_only)
-- Recordings of a line, without network addresses.
DissectorTable.get("wtap_encap"):add(wtap.USER0, lafet)
self = Dissector.get("lafet")
