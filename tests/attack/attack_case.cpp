#include "tests/attack/attack_case.h"

#include <ctime>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "config/blank_of_job.h"
#include "daemon/post/end_ways.h"
#include "daemon/post/near_singularity.h"
#include "daemon/post/part_extent.h"
#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/mesh/mesh_check.h"
#include "tests/attack/proof_judge.h"
#include "tests/attack/random_job.h"
#include "tests/attack/random_part.h"

namespace tiltfeed::attack {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void write(const std::string& path, const std::string& text) {
  std::ofstream out(path);
  if (!(out << text).flush()) throw std::runtime_error("cannot write " + path);
}

Result<JointPath> posted(const Job& job, const CheckedMesh& part, const ToolPath& path) {
  JointPathOptions options;
  const ToleranceBudget budget(job.plan.tolerance);
  options.tolerance = job.axis_tolerance.radians() > 0.0 ? budget.joints_beside_pole() : budget.joints();
  options.reach = job.plan.cutter.shank_length;
  const Angle lean = Angle::from_radians(options.tolerance / job.plan.cutter.shank_length);
  options.axis_tolerance = std::min(options.axis_tolerance, lean.degrees());
  options.linear_decimals = job.machine.format.linear_decimals;
  options.rotary_decimals = job.machine.format.rotary_decimals;
  options.clear = part_extent(part.mesh, job);
  return to_joints(path, job.machine.model, job.setup, options, {});
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
  const double start = processor_seconds();
  auto job = load_job(job_path);
  if (!job) return refused(result, job.error());
  const auto stl = read_stl(job->stl_path, job->stl_unit_mm);
  if (!stl) return refused(result, stl.error());
  const auto part = check_mesh(*stl, {ToleranceBudget(job->plan.tolerance).repair()});
  if (!part) return refused(result, part.error());
  result.facets = part->mesh.facets.size();
  if (const auto added = add_blank(*job, *part); !added) return refused(result, added.error());
  auto planned = plan(*part, job->plan, {});
  result.plan_seconds = processor_seconds() - start;
  if (!planned) return refused(result, planned.error());
  bend_near_singularity(*job, *part, planned->path);
  add_end_ways(planned->path, part->mesh, *job);
  const auto joints = posted(*job, *part, planned->path);
  result.plan_seconds = processor_seconds() - start;
  if (!joints) return refused(result, joints.error());
  result.moves = joints->moves.size();
  result.verdict = judge(*job, *stl, *part, *planned, *joints);
  const ProofVerdict proof = judge_proof(*job, *part, *joints, result.verdict.in_part);
  auto& findings = result.verdict.findings;
  findings.insert(findings.end(), proof.findings.begin(), proof.findings.end());
  result.refusal = proof.refusal;
  result.damaged = proof.damaged, result.damaged_refused = proof.refused;
  result.judge_seconds = processor_seconds() - start - result.plan_seconds;
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
