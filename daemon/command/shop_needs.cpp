#include "daemon/command/shop_needs.h"

#include <algorithm>
#include <charconv>

#include "config/job.h"
#include "config/magazine.h"
#include "daemon/program/block_cursor.h"
#include "daemon/program/tool_change.h"

namespace tiltfeed::daemon {

namespace {

constexpr int kLargestTool = 1000000;

void add_tool(ShopNeeds& needs, const ShopTool& tool) {
  if (std::find(needs.tools.begin(), needs.tools.end(), tool) == needs.tools.end())
    needs.tools.push_back(tool);
}

Result<ShopTool> tool_of(const std::string& word) {
  ShopTool tool;
  const auto read = std::from_chars(word.data(), word.data() + word.size(), tool.number);
  if (read.ec == std::errc() && read.ptr == word.data() + word.size()) {
    if (tool.number >= 1 && tool.number <= kLargestTool) return tool;
    return fail(Code::kUsage, "--tool " + word + ": expected a number from 1 on, or an id");
  }
  return ShopTool{0, word};
}

/// Words are places of the axes, and this reader knows them.
bool states_axes(const config::ProgramFormat& format) {
  const bool known = format.dialect == config::Dialect::kRs274 || format.dialect == config::Dialect::kGrbl;
  return known && !format.tcp && !format.tilted_planes;
}

/// Where the axes go, by every move of the program.
Result<std::vector<ShopTravel>> travels_of(const std::string& file, const MachineModel& machine) {
  auto cursor = BlockCursor::open(file, LinkKind::kGrbl, machine);
  if (!cursor) return tl::unexpected<Error>(cursor.error());
  constexpr std::size_t kAxes = 5;
  std::vector<ShopTravel> all = {
      {'X', 0, 0}, {'Y', 0, 0}, {'Z', 0, 0}, {machine.tilt.letter, 0, 0}, {machine.rotary.letter, 0, 0}};
  bool seen[kAxes] = {};
  WalkedBlock block;
  for (;;) {
    const Result<bool> more = cursor->next(block);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    const NumericBlock& at = block.state;
    if (!block.is_move || at.machine) continue;
    if (at.lost != 0) return fail(Code::kInput, "moves with G91 end where the program does not say");
    const double places[kAxes] = {at.x, at.y, at.z, at.tilt, at.rotary};
    for (std::size_t i = 0; i < kAxes; ++i) {
      if ((((at.kept | at.absent) >> i) & 1U) != 0) continue;
      all[i].min = seen[i] ? std::min(all[i].min, places[i]) : places[i];
      all[i].max = seen[i] ? std::max(all[i].max, places[i]) : places[i];
      seen[i] = true;
    }
  }
  std::vector<ShopTravel> travels;
  for (std::size_t i = 0; i < kAxes; ++i)
    if (seen[i]) travels.push_back(all[i]);
  return travels;
}

Result<FoundNeeds> needs_of_program(const std::string& file, const ShopWishes& wishes) {
  if (wishes.machine.empty())
    return fail(Code::kUsage, "a program is made for one kind of machine: name its profile with --machine");
  const Result<config::MachineProfile> profile = config::load_machine(wishes.machine);
  if (!profile) return tl::unexpected<Error>(profile.error());
  FoundNeeds found;
  found.needs.profile = profile->model.name;
  if (!wishes.any_values) found.needs.values = profile_values(*profile);
  found.needs.dialect = config::name_of(profile->format.dialect).name;
  if (!states_axes(profile->format)) {
    found.unread = "travels and tools are not read from a program of this kind; name tools with --tool";
    return found;
  }
  if (auto travels = travels_of(file, profile->model))
    found.needs.travels = std::move(*travels);
  else
    found.unread = "its travels are not known: " + travels.error().message;
  const auto changes = read_tool_changes(file, LinkKind::kGrbl, numeric_axes(profile->model));
  if (!changes) return tl::unexpected<Error>(changes.error());
  for (const ToolChange& change : *changes)
    if (change.tool && *change.tool >= 1 && *change.tool <= kLargestTool)
      add_tool(found.needs, {*change.tool, ""});
  return found;
}

Result<FoundNeeds> needs_of_job(const std::string& file, const ShopWishes& wishes) {
  const auto operations = config::load_operations(file, {});
  if (!operations) return tl::unexpected<Error>(operations.error());
  FoundNeeds found;
  if (!wishes.any_machine) found.needs.profile = operations->front().machine.model.name;
  for (const config::Job& one : *operations)
    if (!one.tool_id.empty() || one.program.tool > 0) add_tool(found.needs, {one.program.tool, one.tool_id});
  return found;
}

}  // namespace

Result<FoundNeeds> find_needs(const std::string& file, bool program, const ShopWishes& wishes) {
  if (program && wishes.any_machine)
    return fail(Code::kUsage,
                "--any-machine is for jobs that are planned where they run; a program is made already");
  Result<FoundNeeds> found = program ? needs_of_program(file, wishes) : needs_of_job(file, wishes);
  if (!found) return found;
  for (const std::string& word : wishes.tools) {
    const Result<ShopTool> tool = tool_of(word);
    if (!tool) return tl::unexpected<Error>(tool.error());
    add_tool(found->needs, *tool);
  }
  return found;
}

}  // namespace tiltfeed::daemon
