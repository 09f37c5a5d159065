"""pymodbus: a server of 16 registers, and a client that asks for four."""

import asyncio
import logging
import sys
import time

from pymodbus.client import AsyncModbusTcpClient
from pymodbus.datastore import ModbusDeviceContext, ModbusSequentialDataBlock, ModbusServerContext
from pymodbus.server import StartAsyncTcpServer

logging.disable(logging.CRITICAL)


async def serve(port):
    registers = ModbusSequentialDataBlock(1, [0x41] * 16)
    context = ModbusServerContext(devices=ModbusDeviceContext(hr=registers), single=True)
    await StartAsyncTcpServer(context, address=("127.0.0.1", port))


async def ask(port, seconds):
    client = AsyncModbusTcpClient("127.0.0.1", port=port)
    await client.connect()
    took = []
    busy = time.process_time()
    start = before = time.perf_counter()
    while before - start < seconds:
        answer = await client.read_holding_registers(0, count=4)
        if answer.isError() or len(answer.registers) != 4:
            sys.exit("pymodbus: no answer")
        after = time.perf_counter()
        took.append(after - before)
        before = after
    busy = time.process_time() - busy
    took.sort()
    print(f"{len(took)} {took[len(took) * 99 // 100] * 1e6:.2f} {busy:.6f}")


if sys.argv[1] == "serve":
    asyncio.run(serve(int(sys.argv[2])))
else:
    asyncio.run(ask(int(sys.argv[2]), float(sys.argv[3])))
