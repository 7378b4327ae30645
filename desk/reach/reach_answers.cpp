#include "desk/reach/reach_answers.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "config/job.h"
#include "config/part_reading.h"
#include "desk/reach/facet_patch.h"
#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl_facets.h"
#include "pathgen/plan/exact_reach.h"
#include "pathgen/reach/reach_scene.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;
using pathgen::Reach;
using pathgen::ReachMap;

/// Of a facet of the file that the checked mesh has not.
constexpr std::uint8_t kNone = 255;

std::string text(const json& value) { return value.dump(-1, ' ', true, json::error_handler_t::replace); }

std::string refusal_of(json id, const char* what, const std::string& why) {
  return text({{"id", std::move(id)}, {"do", what}, {"state", "refused"}, {"error", why}});
}

/// What of a job a scene is made of, as words.
std::string tool_words(const config::Job& job) {
  std::istringstream all(config::describe(job));
  std::string words;
  for (std::string line; std::getline(all, line);)
    for (const char* start :
         {"cutter.", "guards.", "stock.", "tolerance_mm", "allowance_mm", "axis.steepest"})
      if (line.rfind(start, 0) == 0) words += line + "\n";
  return words;
}

pathgen::ReachQuestion question_of(const config::Job& job, const pathgen::MachineReach& machine) {
  pathgen::ReachQuestion question;
  question.axis = job.plan.axis;
  question.up = job.plan.up;
  question.tilt_max = job.plan.tilt_max;
  question.machine = &machine;
  return question;
}

/// One byte for each facet of the file: of its pieces in the mesh the largest speaks.
std::vector<std::uint8_t> bytes_of(const ReachMap& map, const std::vector<pathgen::ReachPlace>& places,
                                   const pathgen::Mesh& mesh, std::size_t facets) {
  std::vector<std::uint8_t> bytes(facets, kNone);
  std::vector<double> area(facets, 0.0);
  for (std::size_t i = 0; i < map.places.size(); ++i) {
    const std::size_t from = mesh.source[i];
    if (places[i].area <= area[from]) continue;
    area[from] = places[i].area;
    bytes[from] = static_cast<std::uint8_t>(map.places[i]);
  }
  return bytes;
}

json percent_of(const ReachMap& map) {
  json percent = json::object();
  for (std::size_t i = 0; i < pathgen::kReaches; ++i) {
    const auto reach = static_cast<Reach>(i);
    if (map.area[i] > 0.0) percent[pathgen::word_of(reach)] = 100.0 * map.share(reach);
  }
  return percent;
}

}  // namespace

namespace {

/// The facets that are drawn: `bodies` and `deviation` of the question.
config::PartRequest file_of(const json& asked, const std::string& stl, double unit_mm) {
  config::PartRequest file{stl, unit_mm};
  file.bodies = asked.value("bodies", std::vector<std::string>{});
  if (const double deviation = asked.value("deviation", 0.0); deviation > 0.0) file.deviation = deviation;
  return file;
}

}  // namespace

struct ReachAnswers::Kept {
  std::string part, tool;  // what is kept was made of these
  std::size_t facets = 0;  // of the file
  std::optional<pathgen::CheckedMesh> mesh;
  std::unique_ptr<pathgen::ReachScene> scene;
  std::vector<pathgen::ReachPlace> places;

  Result<void> load(const config::PartRequest& file, double tolerance, const std::string& key);
  Result<void> prepare(const config::Job& job, const json& asked);
  std::string reach(const json& asked, const std::function<bool()>& newer);
  std::string fit(const json& asked);
};

Result<void> ReachAnswers::Kept::load(const config::PartRequest& file, double tolerance,
                                      const std::string& key) {
  if (key == part) return {};
  const Result<pathgen::PartModel> model = config::read_part_file(file);
  if (!model) return tl::unexpected<Error>(model.error());
  const pathgen::Stl* const read = &model->mesh;
  Result<pathgen::CheckedMesh> checked = pathgen::check_mesh(*read, {ToleranceBudget(tolerance).repair()});
  if (!checked) return tl::unexpected<Error>(checked.error());
  scene.reset();
  mesh.emplace(std::move(*checked));
  facets = read->facets.size();
  part = key;
  return {};
}

Result<void> ReachAnswers::Kept::prepare(const config::Job& job, const json& asked) {
  const std::string key = text(asked.at("part")) + " " + std::to_string(job.stl_unit_mm) + " " +
                          std::to_string(job.plan.tolerance);
  if (Result<void> loaded = load(file_of(asked, job.stl_path, job.stl_unit_mm), job.plan.tolerance, key);
      !loaded)
    return loaded;
  const std::string words = tool_words(job);
  if (scene && words == tool) return {};
  scene = std::make_unique<pathgen::ReachScene>(*mesh, job.plan);
  places = scene->facets();
  tool = words;
  return {};
}

std::string ReachAnswers::Kept::reach(const json& asked, const std::function<bool()>& newer) {
  const auto start = std::chrono::steady_clock::now();
  const std::string file = asked.at("job");
  const std::string operation = asked.value("operation", "");
  auto jobs = config::load_operations(
      file, {.stl = asked.at("stl"), .machine = asked.at("machine"), .operation = operation});
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
  if (!jobs) return refusal_of(asked.at("id"), "reach", jobs.error().message);
  config::Job* const job = &jobs->front();
  job->plan.rest_more_than = 0.0;  // where the tool can be, whatever is left there
  if (const Result<void> ready = prepare(*job, asked); !ready)
    return refusal_of(asked.at("id"), "reach", ready.error().message);
  const pathgen::MachineReach machine(job->machine.model, job->setup);
  const pathgen::ReachQuestion question = question_of(*job, machine);
  const bool exact = asked.at("exact");
  ReachMap map;
  if (exact) {
    Result<ReachMap> planned = pathgen::exact_reach(*mesh, job->plan, *scene, places, question,
                                                    [&](const char*, double) { return !newer(); });
    if (!planned && planned.error().code == Code::kCancelled) return "";
    if (!planned) return refusal_of(asked.at("id"), "reach", planned.error().message);
    map = std::move(*planned);
  } else {
    map = scene->ask(question, places, pathgen::Rays::kAxis);
  }
  const std::vector<std::uint8_t> bytes = bytes_of(map, places, mesh->mesh, facets);
  const std::string out = asked.at("out");
  std::ofstream stream(out, std::ios::binary | std::ios::trunc);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!stream.flush())
    return refusal_of(asked.at("id"), "reach", "the answer cannot be written; is the disk full?");
  const double ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return text({{"id", asked.at("id")},
               {"do", "reach"},
               {"of", asked.at("of")},
               {"state", "ready"},
               {"exact", exact},
               {"percent", percent_of(map)},
               {"ms", ms}});
}

std::string ReachAnswers::Kept::fit(const json& asked) {
  const std::string key = text(asked.at("part")) + " fit";
  if (!mesh || part.rfind(text(asked.at("part")) + " ", 0) != 0)
    if (const Result<void> loaded = load(file_of(asked, asked.at("stl"), asked.at("unit_mm")), 0.01, key);
        !loaded)
      return refusal_of(asked.at("id"), "fit", loaded.error().message);
  const std::vector<std::uint32_t> picked = asked.at("facets");
  const FacetPatch patch = smooth_patch(mesh->mesh, picked, asked.at("spread_deg"));
  json shapes = json::array();
  for (const pathgen::Fit& found : fits_of(mesh->mesh, patch.facets))
    shapes.push_back({{"kind", pathgen::word_of(found.kind)},
                      {"centre_mm", {found.centre.x, found.centre.y, found.centre.z}},
                      {"axis", {found.axis.x, found.axis.y, found.axis.z}},
                      {"radius_mm", found.radius},
                      {"tube_mm", found.tube},
                      {"rms_mm", found.rms},
                      {"worst_mm", found.worst},
                      {"points", found.points}});
  return text({{"id", asked.at("id")},
               {"do", "fit"},
               {"state", "ready"},
               {"facets", patch.sources},
               {"shapes", shapes}});
}

ReachAnswers::ReachAnswers() : kept_(std::make_unique<Kept>()) {}
ReachAnswers::~ReachAnswers() = default;

std::string ReachAnswers::answer(const std::string& question, const std::function<bool()>& newer) {
  try {
    const json asked = json::parse(question);
    return asked.at("do") == "fit" ? kept_->fit(asked) : kept_->reach(asked, newer);
  } catch (const json::exception& error) {
    return refusal_of(nullptr, "", std::string("no question: ") + error.what());
  }
}

}  // namespace tiltfeed::desk
