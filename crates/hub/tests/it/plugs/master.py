"""A master with pymodbus, for foreign.rs: reads, moves, opens, tries an old key, stops."""

import sys
import time

from pymodbus.client import ModbusSerialClient, ModbusTcpClient

SESSION, RESULTS, KEYS, HEARTBEAT, COMMAND = 128, 136, 168, 256, 264


def connect():
    if sys.argv[1] == "tcp":
        return ModbusTcpClient("127.0.0.1", port=int(sys.argv[2]))
    return ModbusSerialClient(sys.argv[2], baudrate=115200, parity="N", stopbits=2)


class Master:
    def __init__(self):
        self.client = connect()
        assert self.client.connect()
        self.beat = 0
        self.sequence = 0

    def read(self, first, count):
        self.pulse()
        answer = self.client.read_holding_registers(first, count=count, device_id=1)
        assert not answer.isError(), answer
        return answer.registers

    def pulse(self):
        self.beat = (self.beat + 1) % 65536
        answer = self.client.write_register(HEARTBEAT, self.beat, device_id=1)
        assert not answer.isError(), answer

    def command(self, number, arguments, key=None):
        session = self.read(SESSION, 2)
        key = key or self.read(KEYS, 4)
        self.sequence += 1
        block = [self.sequence, *session, number, 1, *arguments, *key]
        answer = self.client.write_registers(COMMAND, block, device_id=1)
        assert not answer.isError(), answer
        for _ in range(500):
            sequence, state, refusal = self.read(RESULTS, 3)
            if sequence == self.sequence and state > 1:
                return f"{state} {refusal}"
            time.sleep(0.02)
        return "no result"


master = Master()
summary = master.read(0, 125)
print("monitors", summary[3])
print("good", sum(summary[5 + 15 * at] & 1 for at in range(8)))
while master.read(SESSION + 3, 1) != [1]:
    time.sleep(0.02)
print("take", master.command(1, [0, 0, 0, 0]))
print("goto", master.command(4, [1, 65536 - 50, 0, 0]))
for _ in range(1000):
    if master.read(9, 1) == [65536 - 50]:
        print("arrived")
        break
    time.sleep(0.02)
key = master.read(KEYS, 4)
print("open", master.command(5, [1, 0, 0, 0], key))
for _ in range(1000):
    if master.read(14, 1)[0] & 1:
        print("opened")
        break
    time.sleep(0.02)
print("wrong key", master.command(5, [1, 0, 0, 0], key))
print("stop", master.command(7, [0, 0, 0, 0]))
