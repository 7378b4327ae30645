#include "daemon/service/job_origin.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/post/block_map.h"
#include "daemon/program/block_cursor.h"
#include "daemon/program/operation_span.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

ordered_json origin_of(const std::string& program, const std::string& map, LinkKind kind,
                       const MachineModel& machine, std::uint64_t number) {
  ordered_json json = {{"block", number}};
  const auto block = find_block(program, kind, machine, number);
  if (!block) {
    json["error"] = block.error().message;
    return json;
  }
  json["line"] = block->line;
  json["text"] = block->text;
  if (const auto operations = read_operations(program, kind, machine))
    if (const OperationSpan* in = operation_at(*operations, number)) json["operation"] = in->name;
  json["machine_seconds"] = std::round(block->seconds * 10.0) / 10.0;
  const NumericBlock& at = block->state;
  json["at"] = {{"x", at.x}, {"y", at.y}, {"z", at.z}, {"tilt", at.tilt}, {"rotary", at.rotary}};
  if (!block->is_move) return json;
  if (const auto origin = read_block_origin(map, block->moves); origin && *origin) {
    json["move"] = (*origin)->move;
    if ((*origin)->facet != kNoFacet) json["facet"] = (*origin)->facet;
  }
  return json;
}

}  // namespace

std::string origin_json(const std::string& program, const std::string& map, LinkKind kind,
                        const MachineModel& machine, std::uint64_t number) {
  return origin_of(program, map, kind, machine, number)
      .dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

}  // namespace tiltfeed::daemon
