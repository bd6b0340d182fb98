% Compares a MAT file with the CSV of the same run, bit for bit.
arguments = argv();
names = strsplit(fgetl(fopen(arguments{1})), ',');
csv = dlmread(arguments{1}, ',', 1, 0);
load(arguments{2});
assert(isstruct(trace) && isequal(size(trace), [1 1]));
assert(isequal(fieldnames(trace), [names'; {'units'; 'meta'}]));
for i = 1:numel(names)
  column = trace.(names{i});
  assert(isa(column, 'double') && isequal(size(column), [rows(csv) 1]));
  assert(isequal(typecast(column, 'uint64'), typecast(csv(:, i), 'uint64')), names{i});
end
assert(isequal(trace.units.rate_deg_s, 'deg/s') && isequal(trace.meta.model, 'board'));
assert(isa(trace.meta.parameters.position_gain, 'double'));
printf('%d rows of %d columns: Octave reads what the CSV says\n', rows(csv), numel(names));
