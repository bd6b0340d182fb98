// What people adjust, with other words for it that the search knows, and the objects behind it.
export const TOPICS = [
  ['Gains of the loops', 'pid pi p i gain stiffness tuning position rate velocity loop integral anti-windup feed-forward', ['60FB:1', '60F9:1', '60F9:2', '60F9:3', '60F9:4', '60F9:5']],
  ['Speed and acceleration', 'speed velocity acceleration deceleration ramp profile slew', ['6081:0', '6083:0', '6084:0', '6085:0', '607F:0', '60FB:2', '60FB:3']],
  ['Travel', 'angle position limit end stop range travel endpoint', ['607D:1', '607D:2']],
  ['Current, duty and heat', 'current limit torque overcurrent overload stall duty power temperature thermal heat protection', ['6073:0', '6072:0', '6087:0', '2100:8', '2100:10', '2100:11', '2100:12', '2100:14', '2100:21', '60F9:6', '60F9:7']],
  ['Supply voltage', 'battery supply voltage undervoltage overvoltage brownout', ['2100:18', '2100:19']],
  ['Bus', 'baud baudrate bitrate bit rate can id address node', ['2102:1', '2102:2']],
  ['Lost commands', 'failsafe timeout watchdog signal loss heartbeat', ['2040:1', '2040:2', '2040:3', '2040:4']],
  ['Servo pulse', 'rc pwm pulse width servo receiver radio centre reverse', ['2000:0', '2001:4', '2001:5', '2001:6', '2001:8']],
  ['Motor', 'motor model resistance torque constant kt kv gear ratio inertia friction', ['2011:1', '2011:2', '2011:3', '2011:4', '2011:5', '2011:6']],
].map(([title, words, objects]) => ({ title, words: `${title} ${words}`.toLowerCase(), objects }));

// The words of the topics of an object, in which the search looks too.
export const wordsOf = address => TOPICS.filter(({ objects }) => objects.includes(address)).map(({ words }) => words).join(' ');
