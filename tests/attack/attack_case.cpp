#include "tests/attack/attack_case.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>

#include "daemon/plan/operation_plan.h"
#include "daemon/plan/shortest_time.h"
#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/part_file/part_model.h"
#include "tests/attack/proof_judge.h"
#include "tests/attack/random_job.h"
#include "tests/attack/random_part.h"
#include "tests/attack/random_surroundings.h"

namespace tiltfeed::attack {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

using EarlierCuts = std::vector<std::shared_ptr<const EarlierCut>>;

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void write(const std::string& path, const std::string& text) {
  std::ofstream out(path);
  if (!(out << text).flush()) throw std::runtime_error("cannot write " + path);
}

/// A made-up model of a mesh file: one face for each name that the job chooses or avoids, of the facets whose
/// middle is in the ball "ball X Y Z RADIUS" (mm) that the name says, and one of all others.
PartModel model_of(const Stl& stl, const std::vector<Job>& jobs) {
  PartModel model;
  std::vector<std::string> names;
  for (const Job& job : jobs)
    for (const auto* list : {&job.avoid_faces, &job.only_faces})
      for (const std::string& name : *list)
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  if (names.empty()) return model;
  model.bodies.emplace_back(), model.faces.emplace_back();
  model.face_of.assign(stl.facets.size(), 0);
  for (const std::string& name : names) {
    Point<Part> at;
    double radius = 0.0;
    if (std::sscanf(name.c_str(), "ball %lf %lf %lf %lf", &at.x, &at.y, &at.z, &radius) != 4)
      throw std::runtime_error("a face of the attack is \"ball X Y Z RADIUS\", found " + name);
    model.faces.emplace_back().name = name;
    for (std::size_t i = 0; i < stl.facets.size(); ++i) {
      const auto& [a, b, c] = stl.facets[i];
      if (distance(lerp(lerp(a, b, 0.5), c, 1.0 / 3.0), at) < radius)
        model.face_of[i] = static_cast<std::uint32_t>(model.faces.size() - 1);
    }
  }
  return model;
}

bool asks_shortest_time(const std::string& job_path) {
  std::ifstream in(job_path);
  for (std::string line; std::getline(in, line);)
    if (line.rfind(kShortestTime, 0) == 0) return true;
  return false;
}

/// One operation as `tiltfeed plan` plans it, up to its joints.
Result<std::unique_ptr<OperationPlan>> planned(const Job& job, std::shared_ptr<const CheckedMesh> part,
                                               const PartModel& model, const EarlierCuts& cuts, bool shortest,
                                               StageClock& clock) {
  static const PlanListener silent;
  const auto once = [&](const Job& one, bool rest) -> Result<std::unique_ptr<OperationPlan>> {
    auto plan = std::make_unique<OperationPlan>(one, clock, silent);
    plan->follow(cuts);
    if (auto done = plan->plan_path(part, model, rest); !done) return tl::unexpected(done.error());
    if (auto done = plan->find_joints(); !done) return tl::unexpected(done.error());
    return plan;
  };
  auto own = once(job, shortest);
  if (!own || !shortest) return own;
  Shortened quick = shorten(**own, [&](const Job& one, bool rest) {
    auto plan = once(one, rest);
    return plan ? std::move(*plan) : nullptr;
  });
  if (quick.plan) return std::move(quick.plan);
  return own;
}

/// Adds what is found of one operation.
void judge_plan(const OperationPlan& plan, const Stl& stl, CaseResult& result) {
  const Job& job = plan.job();
  result.moves += plan.joints().moves.size();
  const Verdict one = judge(job, stl, plan.part(), {plan.cl_path(), plan.plan_report()}, plan.joints());
  const ProofVerdict proof = judge_proof(job, plan.part(), plan.joints(), one.in_part);
  Verdict& all = result.verdict;
  all.gouge = std::max(all.gouge, one.gouge), all.rapid = std::max(all.rapid, one.rapid);
  all.in_part = std::max(all.in_part, one.in_part), all.contact = std::max(all.contact, one.contact);
  all.left = std::max(all.left, one.left);
  all.poses += one.poses, all.surface_points += one.surface_points, all.stock_places += one.stock_places;
  const std::string where = job.operation.name.empty() ? "" : job.operation.name + ": ";
  for (const auto* findings : {&one.findings, &proof.findings})
    for (const std::string& finding : *findings) all.findings.push_back(where + finding);
  result.refusal = proof.refusal;
  result.damaged += proof.damaged, result.damaged_refused += proof.refused;
}

CaseResult refused(CaseResult result, const Error& error) {
  result.refusal = error.message;
  return result;
}

}  // namespace

void prepare(const std::string& folder) {
  std::filesystem::create_directories(folder);
  write(folder + "/wide.yaml", wide_profile());
}

CaseResult run_job(const std::string& job_path) {
  CaseResult result;
  double start = processor_seconds();
  const auto jobs = load_operations(job_path, {});
  if (!jobs) return refused(result, jobs.error());
  const auto stl = read_stl(jobs->front().stl_path, jobs->front().stl_unit_mm);
  if (!stl) return refused(result, stl.error());
  const bool shortest = asks_shortest_time(job_path);
  EarlierCuts cuts;
  StageClock clock;
  for (const Job& job : *jobs) {
    auto checked = check_mesh(*stl, {ToleranceBudget(job.plan.tolerance).repair()});
    if (!checked) return refused(result, checked.error());
    const auto part = std::make_shared<const CheckedMesh>(std::move(*checked));
    result.facets = part->mesh.facets.size();
    const auto plan = planned(job, part, model_of(*stl, *jobs), cuts, shortest, clock);
    result.plan_seconds += processor_seconds() - start;
    start = processor_seconds();
    if (!plan) return refused(result, plan.error());
    judge_plan(**plan, *stl, result);
    result.judge_seconds += processor_seconds() - start;
    start = processor_seconds();
    if (!result.refusal.empty() || !result.verdict.findings.empty()) return result;
    if (jobs->size() > 1) cuts.push_back((*plan)->as_earlier_cut());
  }
  return result;
}

CaseResult run_case(std::uint64_t seed, const CaseFiles& files) {
  Dice dice(seed);
  const RandomPart part = random_part(dice, files.models);
  const std::string name = std::to_string(seed), base = files.folder + "/" + name;
  write(base + ".yaml",
        "# " + part.story + "\n" + random_job(dice, part, "attack-" + name, name + ".stl", "wide.yaml"));
  if (const auto written = write_stl(base + ".stl", part.facets); !written)
    throw std::runtime_error(written.error().message);
  CaseResult result = run_job(base + ".yaml");
  result.story = part.story;
  return result;
}

}  // namespace tiltfeed::attack
