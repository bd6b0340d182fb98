#!/usr/bin/env node
/**
 * node-canopen, a master in JavaScript with an importer and an SDO client of its own, against the actuators of `actuator serve`.
 *
 *     NODE_PATH=.../node_modules node_canopen.js target/debug/actuator target/debug/examples/loopback docs/smart-actuator.eds
 */
'use strict';
require('./crc');
const assert = require('node:assert/strict');
const fs = require('node:fs');
const os = require('node:os');
const path = require('node:path');
const { test } = require('node:test');
const { DataType, Device, Eds, LssMode, NmtState, ObjectType } = require('canopen');
const { Bus, PATIENCE_MS, pause, until } = require('./bus');

const [ACTUATOR, LOOPBACK, SHEET] = process.argv.slice(2);
const { INTEGER8, INTEGER32, UNSIGNED16, UNSIGNED32, VISIBLE_STRING } = DataType;

/** The data sheet of node 1 as a file: node-canopen does not replace $NODEID. */
const sheetOfNode1 = path.join(fs.mkdtempSync(path.join(os.tmpdir(), 'node-canopen-')), 'node-1.eds');
fs.writeFileSync(sheetOfNode1, fs.readFileSync(SHEET, 'utf8').replace(
    /\$NODEID\+(0x[0-9A-F]+)/g, (_, base) => `0x${(Number(base) + 1).toString(16)}`));

/** The value of an SDO, or the abort code. */
const code = (transfer) => transfer.then((value) => value, (error) => error.code ?? error);

/** A master of a node, with short names for its transfers. */
class Master extends Device {
    constructor(bus, node) {
        super({ id: 100, enableLss: true });
        this.node = node;
        bus.join(this);
    }

    get(index, subIndex, dataType, blockTransfer = false) {
        return this.sdo.upload({ deviceId: this.node, index, subIndex, dataType, timeout: PATIENCE_MS, blockTransfer });
    }

    set(index, subIndex, dataType, data, blockTransfer = false) {
        return this.sdo.download(
            { deviceId: this.node, index, subIndex, dataType, data, timeout: PATIENCE_MS, blockTransfer });
    }
}

/** Node 1 of two actuators, with the objects of the data sheet. */
async function withActuator(body) {
    const bus = await Bus.serve([ACTUATOR, 'serve', '--listen', '127.0.0.1:0', '--nodes', '2']);
    try {
        const master = new Master(bus, 1);
        master.mapRemoteNode({ id: 1, eds: Eds.fromFile(sheetOfNode1) });
        master.eds.addHeartbeatConsumer(1, 300);
        master.start();
        await body(master, bus);
    } finally {
        await bus.close();
    }
}

async function test_node_canopen_imports_every_entry_of_the_eds() {
    const sections = [...fs.readFileSync(SHEET, 'utf8').matchAll(/^\[([0-9A-F]{4})(?:sub([0-9A-F]+))?\]\n([^[]*)/gm)];
    assert.ok(sections.length > 300, `${sections.length} entries`);
    const sheet = Eds.fromFile(sheetOfNode1);
    for (const [, index, sub, text] of sections) {
        const keys = Object.fromEntries(text.trim().split('\n').map((line) => line.split('=')));
        const at = parseInt(index, 16);
        const entry = sub === undefined ? sheet.getEntry(at) : sheet.getSubEntry(at, parseInt(sub, 16));
        assert.equal(entry.parameterName, keys.ParameterName);
        assert.equal(entry.objectType, Number(keys.ObjectType), keys.ParameterName);
        assert.equal(entry.accessType, keys.AccessType, keys.ParameterName);
        if (entry.objectType === ObjectType.VAR)
            assert.equal(entry.dataType, Number(keys.DataType), keys.ParameterName);
    }
    assert.deepEqual(sheet.getTransmitPdos().map((pdo) => [pdo.cobId, pdo.eventTime]), [[0x181, 4], [0x281, 4], [0x381, 20]]);
    assert.deepEqual(sheet.getReceivePdos().map((pdo) => pdo.cobId), [0x201, 0x301, 0x401, 0x501]);
}

async function test_node_canopen_uses_all_three_transfer_types() {
    await withActuator(async (master) => {
        for (const block of [false, true]) {
            assert.equal(await master.get(0x1000, 0, UNSIGNED32, block), 0x00020192);
            assert.equal(await master.get(0x1008, 0, VISIBLE_STRING, block), 'SMART-ACTUATOR');
            await master.set(0x607A, 0, INTEGER32, -12345 - block, block);
            assert.equal(await master.get(0x607A, 0, INTEGER32), -12345 - block);
        }
        for (const [index, expected] of [[0x5000, 0x06020000], [0x2032, 0x08000024]])
            for (const block of [false, true])
                assert.equal(await code(master.get(index, 0, UNSIGNED32, block)), expected);
        assert.equal(await code(master.set(0x6041, 0, UNSIGNED16, 1)), 0x06010002);
        assert.equal(await code(master.set(0x6060, 0, INTEGER8, 5)), 0x06090030);
    });
}

async function test_node_canopen_transfers_64_kib_in_blocks_and_segments() {
    const bus = await Bus.serve([LOOPBACK, '0']);
    try {
        const master = new Master(bus, 5);
        master.eds.addSdoClientParameter(5, 0x605, 0x585);
        master.start();
        for (const bytes of [1, 7, 8, 889, 890, 65536]) {
            const data = Buffer.from(Array.from({ length: bytes }, (_, at) => at * 7 + (at >> 8) & 255));
            const request = { deviceId: 5, index: 0x2010, data, timeout: PATIENCE_MS, blockInterval: 0 };
            await master.sdo.download({ ...request, blockTransfer: true });
            assert.ok(data.equals(await master.get(0x2010, 0, DataType.DOMAIN, true)), `${bytes} bytes in blocks`);
            if (bytes > 890)
                continue;
            await master.sdo.download(request);
            assert.ok(data.equals(await master.get(0x2010, 0, DataType.DOMAIN)), `${bytes} bytes in segments`);
        }
    } finally {
        await bus.close();
    }
}

async function test_node_canopen_commands_nmt_states_and_receives_heartbeats() {
    await withActuator(async (master) => {
        const states = [];
        master.nmt.on('heartbeat', ({ state }) => states.push(state));
        master.nmt.on('timeout', () => states.push('silence'));
        await master.set(0x1017, 0, UNSIGNED16, 20);
        for (const [command, state] of [['startNode', NmtState.OPERATIONAL], ['stopNode', NmtState.STOPPED],
            ['enterPreOperational', NmtState.PRE_OPERATIONAL], ['resetNode', NmtState.INITIALIZING]]) {
            master.nmt[command](1);
            await until(() => states.at(-1) === state, command);
        }
        // 1017h is not stored.
        await until(() => states.at(-1) === 'silence', 'the end of the heartbeats');
        assert.equal(await master.get(0x1017, 0, UNSIGNED16), 0);
    });
}

async function test_node_canopen_receives_an_emergency_when_its_heartbeat_is_lost() {
    await withActuator(async (master) => {
        const messages = [];
        master.emcy.on('emergency', ({ em }) => messages.push(em));
        await master.set(0x1016, 1, UNSIGNED32, 100 << 16 | 400);
        master.eds.setHeartbeatProducerTime(20);
        await pause(600);
        assert.equal(messages.length, 0);
        master.eds.setHeartbeatProducerTime(0);
        await until(() => messages.length, 'emergency');
        assert.deepEqual([messages[0].code, messages[0].register], [0x8130, 0x11]);
        assert.equal(await master.get(0x1003, 1, UNSIGNED32) & 0xffff, 0x8130);
    });
}

async function test_node_canopen_drives_the_actuator_by_pdos() {
    await withActuator(async (master, bus) => {
        const received = {};
        master.nmt.startNode();
        master.pdo.on('pdo', ({ dataObjects }) => {
            for (const { parameterName, value } of dataObjects)
                received[parameterName] = value;
        });
        await master.set(0x6060, 0, INTEGER8, 1);
        master.nmt.startNode(1);
        const command = (controlword) => {
            const data = Buffer.alloc(6);
            data.writeUInt16LE(controlword, 0);
            data.writeInt32LE(20000, 2);
            bus.send({ id: 0x401, data });
        };
        for (const [controlword, mask, statusword] of [
            [0x06, 0x6f, 0x21], [0x07, 0x6f, 0x23], [0x0f, 0x6f, 0x27], [0x1f, 0x1000, 0x1000], [0x0f, 0x1400, 0x0400]]) {
            command(controlword);
            await until(() => (received.Statusword & mask) === statusword, `the answer to ${controlword.toString(16)}h`);
        }
        assert.equal(received['Modes of operation display'], 1);
        assert.ok(Math.abs(received.Angle - 2000) < 50, `${received.Angle} hundredths of a degree`);
    });
}

async function test_node_canopen_triggers_a_pdo_with_each_sync() {
    await withActuator(async (master, bus) => {
        await master.set(0x1803, 2, DataType.UNSIGNED8, 1);
        const identifier = await master.get(0x1803, 1, UNSIGNED32);
        await master.set(0x1803, 1, UNSIGNED32, (identifier & 0x7fffffff) >>> 0);
        master.nmt.startNode(1);
        await pause(100);
        const count = () => bus.frames.filter(({ id }) => id === 0x481).length;
        const before = count();
        master.eds.setSyncCobId(0x80);
        master.eds.setSyncGenerationEnable(true);
        for (let sync = 0; sync < 5; ++sync) {
            master.sync.write();
            await pause(20);
        }
        await until(() => count() >= before + 5, 'a PDO for each SYNC');
        assert.equal(count(), before + 5);
    });
}

// In fast scan a missing response means a set bit. The response of a busy computer that comes late
// ends the scan without a device, and the scan is repeated with more time for each response.
const SCAN_TIMEOUTS_MS = [100, 300, 900];

async function fastscan(lss) {
    const last = SCAN_TIMEOUTS_MS.at(-1);
    for (const timeout of SCAN_TIMEOUTS_MS.slice(0, -1)) {
        const found = await lss.fastscan({ timeout }).catch((error) => {
            assert.equal(error.name, 'LssError');
            return null;
        });
        if (found !== null)
            return found;
        lss.switchModeGlobal(LssMode.OPERATION);
    }
    return lss.fastscan({ timeout: last });
}

async function test_node_canopen_finds_two_actuators_by_lss_and_assigns_node_ids() {
    const bus = await Bus.serve([ACTUATOR, 'serve', '--listen', '127.0.0.1:0', '--nodes', '2', '--unconfigured']);
    try {
        const { lss } = new Master(bus, 1);
        const identity = (serialNumber) => ({ vendorId: 0, productCode: 0x5341, revisionNumber: 0x10000, serialNumber });
        for (const serial of [1, 2]) {
            assert.deepEqual(await fastscan(lss), identity(serial));
            assert.equal(await lss.inquireSerialNumber(PATIENCE_MS), serial);
            await assert.rejects(lss.configureNodeId(128, PATIENCE_MS), /out of range/);
            await lss.configureNodeId(3 - serial, PATIENCE_MS);
            await lss.storeConfiguration(PATIENCE_MS);
            lss.switchModeGlobal(LssMode.OPERATION);
            await until(() => bus.frames.some(({ id }) => id === 0x700 + 3 - serial), 'boot-up');
        }
        assert.equal(await lss.fastscan({ timeout: SCAN_TIMEOUTS_MS.at(-1) }), null);
        await lss.switchModeSelective({ ...identity(2), timeout: PATIENCE_MS });
        assert.equal(await lss.inquireSerialNumber(PATIENCE_MS), 2);
        // Bit timing table of CiA, kbit/s.
        const { deviceInfo } = Eds.fromFile(sheetOfNode1);
        for (const [at, rate] of [1000, 800, 500, 250, 125, null, 50, 20, 10].entries()) {
            const taken = await lss.configureBitTiming(0, at, PATIENCE_MS).then(() => '1', () => '0');
            assert.equal(taken, deviceInfo[`BaudRate_${rate}`] ?? '0', `${rate} kbit/s`);
        }
    } finally {
        await bus.close();
    }
}

for (const body of [
    test_node_canopen_imports_every_entry_of_the_eds,
    test_node_canopen_uses_all_three_transfer_types,
    test_node_canopen_transfers_64_kib_in_blocks_and_segments,
    test_node_canopen_commands_nmt_states_and_receives_heartbeats,
    test_node_canopen_receives_an_emergency_when_its_heartbeat_is_lost,
    test_node_canopen_drives_the_actuator_by_pdos,
    test_node_canopen_triggers_a_pdo_with_each_sync,
    test_node_canopen_finds_two_actuators_by_lss_and_assigns_node_ids,
])
    test(body.name, { timeout: 15 * PATIENCE_MS }, body);
