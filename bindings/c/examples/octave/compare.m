% Compares the MEX function with the traces of the program `actuator`, bit for bit.
%
% Usage: octave compare.m PROGRAM, with actuator_mex in the path.
1;

% The trace of the program, read from its CSV by the names of the columns.
function [columns, names] = simulate(program, model, plant)
  if strcmp(model, 'board')
    model = ['board --plant ' plant];
  end
  command = sprintf('%s simulate %s --input 3211 --every 20 --csv -', program, model);
  [status, text] = system(command);
  assert(status == 0);
  [header, rest] = strtok(text, "\n");
  names = strsplit(header, ',');
  % Not textscan, which rounds the last digit differently.
  columns = reshape(sscanf(strrep(rest, ',', ' '), '%f'), numel(names), []).';
end

function same_bits(what, a, b)
  different = find(typecast(a, 'uint64') != typecast(b, 'uint64'), 1);
  if ! isempty(different)
    error('%s differs in row %d: %.17g and %.17g', what, different, a(different), b(different));
  end
end

% A row of the program has the values after the updates of control step and timer at that instant, before the plant
% advances. The state of the plant is therefore read before the step, the outputs of control step and timer one tick
% later.
function compare(program, model, plant)
  [rows, names] = simulate(program, model, plant);
  column = @(name) rows(:, strcmp(names, name));
  state = actuator_mex(model, plant);
  ticks = 20;
  command = column('command_deg');
  [before, after] = deal(zeros(numel(command), 9));
  for k = 1:numel(command)
    [state, before(k, :)] = actuator_mex(state, command(k), 0);
    [state, after(k, :)] = actuator_mex(state, command(k), 1);
    state = actuator_mex(state, command(k), ticks - 1);
  end
  same_bits('time', before(:, 1), column('time_s'));
  same_bits('command', after(:, 2), column('command_delayed_deg'));
  same_bits('angle', before(:, 3), column('angle_deg'));
  % Rate and duty of the black boxes and the grey box jump with the command and are in neither reading.
  if strcmp(model, 'board')
    same_bits('rate', before(:, 4), column('rate_deg_s'));
    same_bits('duty', after(:, 5), column('duty_pct'));
    same_bits('measured angle', after(:, 6), column('angle_meas_deg'));
    same_bits('measured rate', after(:, 7), column('rate_meas_deg_s'));
  end
  if strcmp(plant, 'bench')
    same_bits('current', before(:, 8), column('current_a'));
    same_bits('back-EMF', before(:, 9), column('back_emf_v'));
  end
  printf('%s, %s: %d rows, the same bits\n', model, plant, numel(command));
end

function expect_error(part, varargin)
  try
    actuator_mex(varargin{:});
  catch caught
    if isempty(strfind(caught.message, part)), rethrow(caught); end;
    return
  end
  error('no error that says "%s"', part);
end

function misuse()
  state = actuator_mex('board', 'first-order');
  expect_error('`bord`', 'bord', 'first-order');
  expect_error('position_gain', 'board', 'first-order', {'P'}, NaN);
  expect_error('as many values', 'board', 'first-order', {'P'}, []);
  expect_error('not finite', state, NaN, 20);
  expect_error('whole number', state, 0, -1);
  expect_error('whole number', state, 0, NaN);
  expect_error('not started', zeros(size(state), 'uint64'), 0, 1);
  expect_error('expected', state(1:10), 0, 1);
  expect_error('expected');
end

function a_snapshot_goes_on_as_the_original()
  state = actuator_mex('board', 'bench');
  [kept, first] = actuator_mex(state, 30 * ones(100, 1), 80);
  [~, one] = actuator_mex(kept, -20 * ones(50, 1), 80);
  [~, other] = actuator_mex(kept, -20 * ones(50, 1), 80);
  assert(isequal(one, other) && one(1) > first(end, 1));
end

program = argv(){end};
% Only the board has a plant.
for model = {'black-box-1', 'black-box-2', 'grey-box'}
  compare(program, model{1}, '');
end
compare(program, 'board', 'first-order');
compare(program, 'board', 'bench');
misuse();
a_snapshot_goes_on_as_the_original();
disp('misuse causes errors, a snapshot continues as the original')
