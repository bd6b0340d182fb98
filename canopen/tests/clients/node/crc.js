'use strict';
/**
 * Replaces `node-crc`, of which node-canopen uses only the checksum of block transfers
 * (CRC-16/XMODEM): that package has to be compiled for each version of node.
 */
function crc(width, reflected, polynomial, polynomialLow, initial, initialLow, final, finalLow, data) {
    let remainder = initial;
    for (const byte of data) {
        remainder ^= byte << 8;
        for (let bit = 0; bit < 8; ++bit)
            remainder = (remainder & 0x8000 ? remainder << 1 ^ polynomial : remainder << 1) & 0xffff;
    }
    return Buffer.from([remainder >> 8, remainder & 0xff]);
}

const path = require.resolve('node-crc');
require.cache[path] = { id: path, filename: path, loaded: true, exports: { crc } };
