// A browser's part of CNCjs: signs in, opens the port, and passes on what it reads on standard input, one JSON array
// a line: ["command", "homing"]. Events that matter are printed, one JSON array a line.
const http = require('http');
const readline = require('readline');
const [modules, server, port] = process.argv.slice(2);
const io = require(modules + '/socket.io-client');

const say = (...words) => process.stdout.write(JSON.stringify(words) + '\n');
const request = http.request(server + '/api/signin', { method: 'POST', headers: { 'Content-Type': 'application/json' } }, (answer) => {
    let text = '';
    answer.on('data', (part) => { text += part; });
    answer.on('end', () => begin(JSON.parse(text).token));
});
request.on('error', (error) => { say('unreachable', String(error)); process.exit(1); });
request.end('{}');

function begin(token) {
    const socket = io.connect(server, { query: 'token=' + token });
    socket.on('connect', () => {
        socket.emit('open', port, { baudrate: 115200, controllerType: 'Grbl' }, (error) => say('open', error ? String(error) : null));
    });
    socket.on('error', (error) => say('error', String(error)));
    socket.on('controller:state', (type, state) => say('state', state));
    socket.on('controller:settings', (type, settings) => say('settings', Object.keys(settings.settings || {}).length, settings.version));
    socket.on('sender:status', (status) => say('sender', status));
    socket.on('workflow:state', (state) => say('workflow', state));
    socket.on('serialport:read', (line) => say('read', line));
    readline.createInterface({ input: process.stdin }).on('line', (line) => {
        const [what, ...words] = JSON.parse(line);
        socket.emit(what, port, ...words);
    });
}
