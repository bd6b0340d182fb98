'use strict';
/**
 * A separate server for each test, and the frames of its bus: slcan over TCP in the format of
 * node-canopen.
 */
const { spawn } = require('node:child_process');
const { once } = require('node:events');
const net = require('node:net');
const readline = require('node:readline');
const { setTimeout: pause } = require('node:timers/promises');

/** Response timeout, ms, for a busy computer. */
const PATIENCE_MS = 4000;

class Bus {
    /** Starts the server that `command` names; its first output line contains the port. */
    static async serve(command) {
        const bus = new Bus();
        bus.server = spawn(command[0], command.slice(1), { stdio: ['ignore', 'pipe', 'inherit'] });
        const [line] = await once(readline.createInterface({ input: bus.server.stdout }), 'line');
        bus.socket = net.connect(Number(/127\.0\.0\.1:(\d+)/.exec(line)[1]), '127.0.0.1').setNoDelay(true);
        await once(bus.socket, 'connect');
        bus.socket.on('data', (bytes) => bus.receive(bytes));
        bus.socket.write('C\rS8\rO\r');
        return bus;
    }

    constructor() {
        this.rest = '';
        this.devices = [];
        this.frames = [];
    }

    /** Connects the bus to a device of node-canopen. */
    join(device) {
        device.addListener('message', (message) => this.send(message));
        this.devices.push(device);
        return device;
    }

    send({ id, data = Buffer.alloc(0) }) {
        const head = id.toString(16).padStart(3, '0') + data.length;
        this.socket.write(`t${head}${data.toString('hex')}\r`);
    }

    receive(bytes) {
        const lines = (this.rest + bytes.toString('latin1')).split(/[\r\x07]/);
        this.rest = lines.pop();
        for (const line of lines) {
            const [, id, data] = /^t(.{3}).(.*)$/.exec(line) || [];
            if (!id)
                continue;
            const frame = { id: parseInt(id, 16), data: Buffer.from(data, 'hex') };
            this.frames.push(frame);
            for (const device of this.devices)
                device.receive(frame);
        }
    }

    async close() {
        for (const device of this.devices)
            device.stop();
        // The server may reset the connection.
        this.socket.removeAllListeners('data').on('error', () => {});
        const ended = once(this.server, 'exit');
        this.server.kill('SIGKILL');
        await ended;
        this.socket.destroy();
    }
}

/** Waits until the condition holds. */
async function until(condition, what) {
    const end = Date.now() + PATIENCE_MS;
    while (!await condition()) {
        if (Date.now() > end)
            throw new Error(`waited without success for ${what}`);
        await pause(2);
    }
}

module.exports = { Bus, PATIENCE_MS, pause, until };
