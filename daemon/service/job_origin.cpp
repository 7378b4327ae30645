#include "daemon/service/job_origin.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "config/table_home.h"
#include "daemon/journal/control_block.h"
#include "daemon/post/block_map.h"
#include "daemon/program/block_cursor.h"
#include "daemon/program/operation_span.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

void add_origin(ordered_json& json, const std::string& map, std::uint64_t moves) {
  if (const auto origin = read_block_origin(map, moves); origin && *origin) {
    json["move"] = (*origin)->move;
    if ((*origin)->facet != kNoFacet) json["facet"] = (*origin)->facet;
  }
}

/// Of a Fanuc or Haas. Where its table turns as TCP begins, the text has blocks that the map has not.
ordered_json control_origin(const std::string& program, const std::string& map,
                            const config::MachineProfile& machine, std::uint64_t number) {
  ordered_json json = {{"block", number}};
  const auto block = find_control_block(program, machine, number);
  if (!block) {
    json["error"] = block.error().message;
    return json;
  }
  json["line"] = block->line;
  json["text"] = block->text;
  if (block->words)
    json["at"] = {{"x", block->words->x},
                  {"y", block->words->y},
                  {"z", block->words->z},
                  {"tilt", block->words->a},
                  {"rotary", block->words->c}};
  const bool turns = block->tcp && !config::table_turns(machine.model).empty();
  if (block->is_move && !turns) add_origin(json, map, block->moves);
  return json;
}

ordered_json origin_of(const std::string& program, const std::string& map, LinkKind kind,
                       const config::MachineProfile& machine, std::uint64_t number) {
  if (kind == LinkKind::kDrip && in_control_words(machine))
    return control_origin(program, map, machine, number);
  ordered_json json = {{"block", number}};
  const auto block = find_block(program, kind, machine.model, number);
  if (!block) {
    json["error"] = block.error().message;
    return json;
  }
  json["line"] = block->line;
  json["text"] = block->text;
  if (const auto operations = read_operations(program, kind, machine.model))
    if (const OperationSpan* in = operation_at(*operations, number)) json["operation"] = in->name;
  json["machine_seconds"] = std::round(block->seconds * 10.0) / 10.0;
  const NumericBlock& at = block->state;
  json["at"] = {{"x", at.x}, {"y", at.y}, {"z", at.z}, {"tilt", at.tilt}, {"rotary", at.rotary}};
  if (!block->is_move) return json;
  add_origin(json, map, block->moves);
  return json;
}

}  // namespace

std::string origin_json(const std::string& program, const std::string& map, LinkKind kind,
                        const config::MachineProfile& machine, std::uint64_t number) {
  return origin_of(program, map, kind, machine, number)
      .dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

}  // namespace tiltfeed::daemon
