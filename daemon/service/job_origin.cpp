#include "daemon/service/job_origin.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/post/block_map.h"
#include "daemon/program/block_cursor.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

std::string text_of(const ordered_json& json) {
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

double tenth(double seconds) { return std::round(seconds * 10.0) / 10.0; }

}  // namespace

std::string origin_json(const std::string& program, const std::string& map, LinkKind kind,
                        const MachineModel& machine, std::uint64_t number) {
  ordered_json json = {{"block", number}};
  const auto block = find_block(program, kind, machine, number);
  if (!block) {
    json["error"] = block.error().message;
    return text_of(json);
  }
  json["line"] = block->line;
  json["text"] = block->text;
  json["machine_seconds"] = tenth(block->seconds);
  const NumericBlock& at = block->state;
  json["at"] = {{"x", at.x}, {"y", at.y}, {"z", at.z}, {"tilt", at.tilt}, {"rotary", at.rotary}};
  if (!block->is_move) return text_of(json);
  if (const auto origin = read_block_origin(map, block->moves); origin && *origin) {
    json["move"] = (*origin)->move;
    if ((*origin)->facet != kNoFacet) json["facet"] = (*origin)->facet;
  }
  return text_of(json);
}

}  // namespace tiltfeed::daemon
