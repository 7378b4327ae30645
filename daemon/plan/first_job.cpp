#include "daemon/plan/first_job.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "daemon/plan/formatted.h"
#include "daemon/plan/part_size.h"

namespace tiltfeed::daemon {
namespace {

constexpr std::size_t kMostToolsTried = 3;

double longest_side(const pathgen::Box& bounds) {
  const Vec3 size = bounds.max - bounds.min;
  return std::max({size.x, size.y, size.z});
}

/// A tool that is tried.
struct Candidate {
  config::NamedCutter cutter;
  const config::LibraryTool* tool = nullptr;  ///< null: none of a library
};

bool in_machine(const config::LibraryTool& tool, const config::Magazine& magazine) {
  return magazine.empty() || std::any_of(magazine.begin(), magazine.end(),
                                         [&](const config::MagazineTool& one) { return one.id == tool.id; });
}

bool has_data(const config::LibraryTool& tool, const std::string& material) {
  return material.empty() ||
         std::any_of(tool.data.begin(), tool.data.end(),
                     [&](const config::CuttingData& one) { return one.material == material; });
}

/// The largest first.
Result<std::vector<Candidate>> candidates(const FirstJobOrder& order) {
  const std::string usual = config::usual_cutter(longest_side(order.part.bounds));
  const auto ball = config::parse_cutter(usual);
  if (!ball) return tl::unexpected(ball.error());
  if (!order.library) return std::vector<Candidate>{{*ball, nullptr}};
  std::vector<Candidate> all;
  for (const config::LibraryTool& tool : order.library->tools) {
    const bool round =
        tool.cutter.type == pathgen::CutterType::kBall || tool.cutter.type == pathgen::CutterType::kTaperBall;
    if (tool.lacks.empty() && round && in_machine(tool, order.machine.magazine) &&
        has_data(tool, order.material))
      all.push_back({{tool.cutter, config::cutter_text(tool.cutter)}, &tool});
  }
  if (all.empty())
    return fail(Code::kInput,
                order.library->path + ": no ball or taper ball in it is whole" +
                    (order.machine.magazine.empty() ? "" : ", in the machine's magazine") +
                    (order.material.empty() ? "" : " and has cutting data for " + order.material) +
                    "; leave out --tools, or add one");
  const auto off = [&](const Candidate& one) {
    return std::abs(std::log(one.cutter.cutter.diameter / ball->cutter.diameter));
  };
  std::stable_sort(all.begin(), all.end(),
                   [&](const Candidate& one, const Candidate& other) { return off(one) < off(other); });
  all.resize(std::min(all.size(), kMostToolsTried));
  std::stable_sort(all.begin(), all.end(), [](const Candidate& one, const Candidate& other) {
    return one.cutter.cutter.diameter > other.cutter.cutter.diameter;
  });
  return all;
}

/// What a tool comes to.
struct Tried {
  Candidate tool;
  pathgen::Suggestions found;
  double reached = 0.0;
};

/// Those with which anything is reached. Errors: of the last, where there is none.
Result<std::vector<Tried>> try_tools(const FirstJobOrder& order, const std::vector<Candidate>& tools,
                                     const pathgen::Progress& progress) {
  std::vector<Tried> tried;
  std::optional<Error> last;
  for (const Candidate& tool : tools) {
    pathgen::SuggestOptions asked;
    asked.tool.cutter = tool.cutter.cutter;
    asked.machine = &order.machine.model;
    auto found = pathgen::suggest(order.part, asked, progress);
    if (!found && found.error().code == Code::kCancelled) return tl::unexpected(found.error());
    if (!found) {
      last = found.error();
      continue;
    }
    const double reached = found->proposals.front().share();
    tried.push_back({tool, std::move(*found), reached});
  }
  if (tried.empty()) return tl::unexpected(*last);
  return tried;
}

std::string tools_text(const std::vector<Tried>& tried) {
  std::string text;
  for (const Tried& one : tried) {
    const double diameter = one.tool.cutter.cutter.diameter;
    text += (text.empty() ? "" : ", ") +
            (one.tool.tool == nullptr ? formatted("%.6g mm", diameter) : one.tool.tool->id) +
            formatted(" %.1f %%", 100.0 * one.reached);
  }
  return text;
}

std::vector<std::string> cutter_remarks(const FirstJobOrder& order, const std::vector<Tried>& tried) {
  if (!order.library)
    return {"A ball that goes about forty times into the part: no library was named (--tools).",
            "QUESTION: which tool is it? State its true lengths and its holder: what is not stated is not "
            "checked."};
  return {"The largest that reaches nearly as much of the surface as any that was tried: " +
              tools_text(tried) + ".",
          "QUESTION: is it in the machine, with this length and holder?"};
}

std::vector<std::string> feeds_remarks(const FirstJobOrder& order) {
  if (!order.material.empty())
    return {"Feeds and speed are the tool's for " + order.material + "; keys stated here stand before them."};
  return {"QUESTION: which material, and which feeds? These are a guess."};
}

}  // namespace

Result<std::string> first_job(const FirstJobOrder& order, const pathgen::Progress& progress) {
  const auto tools = candidates(order);
  if (!tools) return tl::unexpected(tools.error());
  const auto tried = try_tools(order, *tools, progress);
  if (!tried) return tl::unexpected(tried.error());
  double most = 0.0;
  for (const Tried& one : *tried) most = std::max(most, one.reached);
  const Tried& taken = *std::find_if(tried->begin(), tried->end(),
                                     [&](const Tried& one) { return one.reached >= kReachesAsMuch * most; });
  const SuggestionOutcome outcome{order.stl,      order.stl_unit_mm, order.part, taken.tool.cutter,
                                  &order.machine, taken.found,       0.0};
  config::NewJob job = job_of(outcome, 0, order.job);
  namespace fs = std::filesystem;
  if (taken.tool.tool != nullptr) {
    const fs::path folder = fs::absolute(order.job).parent_path();
    job.cutter = "library: " +
                 config::quoted_text(fs::absolute(order.library->path).lexically_proximate(folder).string()) +
                 ", id: " + config::quoted_text(taken.tool.tool->id);
    if (!order.material.empty()) job.cutter += ", material: " + config::quoted_text(order.material);
  }
  job.feeds = order.material.empty() ? "cut_mm_per_min: 1000, plunge_mm_per_min: 300" : "";
  job.remarks.insert(
      job.remarks.begin(),
      {"The first job of this part, made by tiltfeed init. Lines with QUESTION want an answer of yours.",
       "All keys are explained in jobs/example.yaml; `tiltfeed check` says what is understood.",
       size_text(order.part.bounds) + formatted(", %zu facets", order.part.mesh.facets.size())});
  job.part_remarks = {"QUESTION: is " + size_text(order.part.bounds) +
                      " the true size? An STL says no unit: part.unit does."};
  config::Job sized;
  sized.machine = order.machine, sized.plan.cutter = taken.tool.cutter.cutter,
  sized.stl_unit_mm = order.stl_unit_mm;
  if (const auto odd = unit_warning(order.part.bounds, sized)) job.part_remarks.push_back(*odd);
  job.cutter_remarks = cutter_remarks(order, *tried);
  job.pattern_remarks = {
      "QUESTION: what is left on the part before, and what shall be left on it? allowance_mm leaves stock; "
      "several",
      "tools take turns in a list of operations (jobs/pin_operations.yaml)."};
  job.feeds_remarks = feeds_remarks(order);
  job.setup_remarks = {
      "QUESTION: where is the part on the table? Measure part_zero_mm there.",
      "QUESTION: what holds it? State vices and clamps under `fixtures`: the tool keeps off what it knows."};
  return config::new_job_text(job);
}

}  // namespace tiltfeed::daemon
