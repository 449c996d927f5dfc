import fs from 'node:fs';
import { Board } from './board.mjs';
import { Elf } from './elf.mjs';
const F='/work/wt/updater/target/firmware/';
const board = new Board(new Elf(fs.readFileSync(F+'vitrine-pico.elf')), new Elf(fs.readFileSync(F+'vitrine-bootloader.elf')));
board.flash.bytes.set(fs.readFileSync('/tmp/updater/1.signed'), 0x10000);
board.setInput(6,false); board.setInput(7,false); board.setAnalog(2, 2707);
board.powerOn();
const t = Date.now();
for (let i = 0; i < 100; i++) { await board.run(board.now + 10e6); if (board.usb.connectedAt) break; }
console.log('ms real', Date.now() - t, 'usb', board.usb.connectedAt/1e6, board.edges.filter(([a,p,l])=>p===25||l).map(([a,p,l]) => [a/1e6,p,l]).slice(0,8));
await board.run(board.now+3e9);
console.log('resets', board.resets, 'high', board.edges.filter(([a,p,l])=>l&&p!==25).length, 'stack', board.stackPeak());
