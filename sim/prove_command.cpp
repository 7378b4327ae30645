#include "sim/prove_command.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <thread>

#include "config/job_files.h"
#include "pathgen/stl.h"
#include "sim/picture.h"
#include "sim/program_proof.h"
#include "sim/text.h"

namespace tiltfeed::sim {
namespace {

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2;
// Of a gouge's picture: so many blocks before and after.
constexpr std::uint64_t kBlocksAround = 150;

int report(const Error& error) {
  std::cerr << "tiltfeed-sim prove: " << error.message << "\n";
  return error.code == Code::kUsage ? kWrongUse : kFailed;
}

std::string gouge_text(const ProvenGouge& g, const std::string& name, const Job& job) {
  const Point<Part> at = g.pose.tip;
  const bool grown = job.plan.allowance > 0.0 || job.plan.radial_stock > 0.0 || job.plan.axial_stock > 0.0;
  return text(
      "%s:%u: gouge: %s %.4f mm deep in the part%s in a %s move, block %llu, tip at (%.3f, %.3f, %.3f), "
      "facet %u; the tolerance is %.4g mm",
      name.c_str(), g.line, kToolPartNames[static_cast<int>(g.tool)], g.depth,
      grown ? " with its allowance" : "", g.rapid ? "rapid" : "feed",
      static_cast<unsigned long long>(g.block), at.x, at.y, at.z, g.facet, job.plan.tolerance);
}

Result<void> draw(std::istream& in, const std::string& name, const Job& job, const CheckedMesh& part,
                  const ProvenGouge& gouge, const std::string& png) {
  const std::uint64_t first = gouge.block > kBlocksAround ? gouge.block - kBlocksAround : 1;
  const auto path = moves_between(in, name, job, first, gouge.block + kBlocksAround);
  if (!path) return tl::unexpected(path.error());
  PictureOptions options;
  options.marks.assign(part.mesh.facets.size(), FacetMark::kNone);
  for (std::size_t i = 0; i < part.mesh.facets.size(); ++i)
    if (part.mesh.source[i] == gouge.facet) options.marks[i] = FacetMark::kUnreached;
  return draw_part_with_path(part.mesh, *path, png, options);
}

}  // namespace

int prove_command(const ProveOptions& options) {
  const std::string& name = options.name.empty() ? options.program : options.name;
  const auto job = load_job_with(options.job, {options.stl, options.machine});
  if (!job) return report(job.error());
  const auto stl = read_stl(job->stl_path, job->stl_unit_mm);
  if (!stl) return report(stl.error());
  const auto part = check_mesh(*stl, {job->plan.tolerance * kRepairShare});
  if (!part) return report(part.error());
  const Prover prover(*part, *job);
  std::string word;
  if (options.told && !std::getline(std::cin, word)) return report({Code::kCancelled, "no program came"});
  std::ifstream in(options.program, std::ios::binary);
  if (!in) return report({Code::kIo, name + ": cannot be opened"});
  const int threads = options.threads > 0
                          ? options.threads
                          : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const auto proven = prove_program(in, name, *job, prover, threads, [&](double share) {
    if (options.progress) std::printf("progress %.3f\n", share), std::fflush(stdout);
    return true;
  });
  if (!proven) return report(proven.error());
  const auto& gouge = proven->proof.deepest;
  if (!gouge) {
    std::printf("proven %llu moves, largest gouge %.4f mm\n",
                static_cast<unsigned long long>(proven->proof.moves), proven->proof.gouge);
    return kDone;
  }
  if (!options.picture.empty())
    if (auto drawn = draw(in, name, *job, *part, *gouge, options.picture); !drawn) report(drawn.error());
  return report({Code::kInput, gouge_text(*gouge, name, *job)});
}

}  // namespace tiltfeed::sim
