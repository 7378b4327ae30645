#include "daemon/journal/control_block.h"

#include <fstream>

#include "daemon/post/nc_reader.h"
#include "daemon/post/nc_rules.h"
#include "daemon/program/line_reader.h"

namespace tiltfeed::daemon {

bool in_control_words(const config::MachineProfile& machine) {
  const config::Dialect dialect = machine.format.dialect;
  return dialect == config::Dialect::kFanuc || dialect == config::Dialect::kHaas;
}

Result<ControlLine> find_control_line(const std::string& path, std::uint64_t number, std::uint64_t behind) {
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected<Error>(program.error());
  ControlLine found;
  for (Line line;;) {
    const Result<bool> more = program->next(line);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) return found;
    ++found.count;
    if (found.count == number) found.line = line.number, found.text = line.text;
    if (behind > 0 && found.next == 0 && line.number > behind) found.next = found.count;
  }
}

Result<ControlPlace> find_control_block(const std::string& path, const config::MachineProfile& machine,
                                        std::uint64_t number) {
  const Result<ControlLine> line = find_control_line(path, number);
  if (!line) return tl::unexpected<Error>(line.error());
  if (line->line == 0)
    return fail(Code::kUsage,
                "block " + std::to_string(number) + ": the program has " + std::to_string(line->count));
  std::ifstream in(path);
  const Result<NcProgram> text = read_nc_program(in, path, text_language(machine));
  if (!text) return tl::unexpected<Error>(text.error());
  ControlPlace place{line->line, line->text, {}, false, false, false, 0};
  for (const TextOperation& op : text->operations)
    for (const TextBlock& block : op.blocks) {
      if (block.line > place.line) return place;
      place.words = block.words;
      place.tcp = block.tcp, place.plane = block.plane != 0;
      place.is_move = block.line == place.line;
      ++place.moves;
    }
  return place;
}

}  // namespace tiltfeed::daemon
