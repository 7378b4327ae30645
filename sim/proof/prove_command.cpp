#include "sim/proof/prove_command.h"

#include <sys/prctl.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <deque>
#include <fstream>
#include <iostream>
#include <span>
#include <thread>
#include <unordered_map>
#include <vector>

#include "config/job.h"
#include "config/job_inputs.h"
#include "config/output_file.h"
#include "config/part_reading.h"
#include "config/program_lines.h"
#include "pathgen/mesh/mesh_check.h"
#include "sim/basics/text.h"
#include "sim/picture/picture.h"
#include "sim/proof/program_proof.h"
#include "sim/proof/stock_rapids.h"

namespace tiltfeed::sim {
namespace {

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2;
// Of a gouge's picture: so many blocks before and after, and what is so many diameters around.
constexpr std::uint64_t kBlocksAround = 150;
constexpr double kDiametersAround = 4.0;

int report(const Error& error) {
  std::cerr << "tiltfeed-sim prove: " << error.message << "\n";
  return error.code == Code::kUsage ? kWrongUse : kFailed;
}

/// The words of a line, counted from 1.
std::string words_at(std::istream& in, std::uint32_t line) {
  in.clear();
  in.seekg(0);
  std::string words;
  for (std::uint32_t i = 0; i < line && std::getline(in, words); ++i) continue;
  while (!words.empty() && (words.back() == '\r' || words.back() == ' ')) words.pop_back();
  return words;
}

/// What helps where the control takes the tool along its own Z, and the part is in that way.
std::string remedy(const std::string& words) {
  if (!config::in_machine_coordinates(words)) return "";
  return "; the way along the machine's Z is not clear there: turn the part (setup.fixture_rotation_deg), or "
         "leave out what is worked there (containment)";
}

std::string gouge_text(const ProvenGouge& g, const std::string& words, const std::string& name,
                       const config::Job& job) {
  const Point<Part> at = g.pose.tip;
  const bool grown = job.plan.allowance > 0.0 || job.plan.radial_stock > 0.0 || job.plan.axial_stock > 0.0;
  return text(
      "%s:%u: gouge: %s %.4f mm deep in the part%s in the %s move \"%.72s\", block %llu, tip at (%.3f, %.3f, "
      "%.3f), facet %u; the tolerance is %.4g mm%s",
      name.c_str(), g.line, kToolPartNames[static_cast<int>(g.tool)], g.depth,
      grown ? " with its allowance" : "", g.rapid ? "rapid" : "feed", words.c_str(),
      static_cast<unsigned long long>(g.block), at.x, at.y, at.z, g.facet, job.plan.tolerance,
      remedy(words).c_str());
}

std::string stock_text(const RapidInStock& found, const std::string& words, const std::string& name,
                       const config::Job& job) {
  const Trouble& t = found.worst;
  return text(
      "%s:%u: rapid in the stock: %s %.4f mm deep in what is left there, in the move \"%.72s\", block %llu, "
      "at (%.3f, %.3f, %.3f); the program starts from %s%s; use %s",
      name.c_str(), t.line, kToolPartNames[static_cast<int>(t.tool)], t.depth, words.c_str(),
      static_cast<unsigned long long>(t.block), t.place.x, t.place.y, t.place.z,
      to_string(found.stock).c_str(),
      job.blank ? ", the job's blank" : ", as the job states no blank (section blank)",
      t.tool == ToolPart::kCutter ? "a larger clearance_mm or approach_mm, or a rough first that comes there"
      : t.tool == ToolPart::kShank
          ? "longer flutes (cutter.cutting_length_mm) or a narrower shank: beside its cuts it stands in stock"
          : "a tool that sticks out further (cutter.shank_length_mm): beside its cuts the holder stands in "
            "stock");
}

/// The facets that come within `near` of p.
pathgen::Mesh around(const pathgen::Mesh& part, Point<Part> p, double near) {
  pathgen::Mesh mesh;
  std::unordered_map<std::uint32_t, std::uint32_t> kept;
  for (std::size_t i = 0; i < part.facets.size(); ++i) {
    const auto& [a, b, c] = part.facets[i];
    const Triangle triangle = make_triangle(part.vertices[a], part.vertices[b], part.vertices[c], 0);
    if (squared_distance(triangle, p) > near * near) continue;
    mesh.facets.push_back(part.facets[i]);
    for (std::uint32_t& corner : mesh.facets.back()) {
      const auto [one, fresh] = kept.try_emplace(corner, static_cast<std::uint32_t>(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back(part.vertices[corner]);
      corner = one->second;
    }
    mesh.source.push_back(part.source[i]);
  }
  return mesh;
}

// Of the proof, what is done when the part is checked, when it can be asked for distances, and when all moves
// are held against it.
constexpr double kChecked = 0.1, kReady = 0.2, kHeld = 0.8;

/// The gouge with the part and the moves about it.
Result<void> draw(std::istream& in, const std::string& name, std::span<const config::Job> operations,
                  const config::Job& job, const pathgen::CheckedMesh& part, const ProvenGouge& gouge,
                  const std::string& png) {
  const std::uint64_t first = gouge.block > kBlocksAround ? gouge.block - kBlocksAround : 1;
  auto path = moves_between(in, name, operations, first, gouge.block + kBlocksAround);
  if (!path) return tl::unexpected(path.error());
  Point<Part> place = gouge.pose.tip;
  for (std::size_t i = 0; i < part.mesh.facets.size(); ++i)
    if (part.mesh.source[i] == gouge.facet) place = part.mesh.vertices[part.mesh.facets[i][0]];
  const double near = distance(place, gouge.pose.tip) + kDiametersAround * job.plan.cutter.diameter;
  std::erase_if(path->moves, [&](const Move& move) {
    return distance(move.pose.tip, gouge.pose.tip) > near && distance(move.pose.tip, place) > near;
  });
  path->moves.push_back({gouge.pose, MoveKind::kCut, kNoFacet});
  const pathgen::Mesh mesh = around(part.mesh, gouge.pose.tip, near);
  PictureOptions options;
  options.marks.assign(mesh.facets.size(), FacetMark::kNone);
  for (std::size_t i = 0; i < mesh.facets.size(); ++i)
    if (mesh.source[i] == gouge.facet) options.marks[i] = FacetMark::kUnreached;
  return draw_part_with_path(mesh, *path, png, options);
}

/// For the planner: where bodies come too near, and the deepest gouge.
void tell_places(const ProgramProof& proven) {
  for (const CollisionPlace& p : proven.collisions.places)
    std::printf("place %zu %d %u %.6f %.6f %.6f %.6f %.6f %s and %s\n", proven.colliding, p.rapid ? 1 : 0,
                p.line, p.words[0], p.words[1], p.words[2], p.words[kTiltAxis], p.words[kRotaryAxis],
                p.first.c_str(), p.second.c_str());
  if (const auto& gouge = proven.proof.deepest)
    std::printf("gouge %zu %d %.6f %.6f %.6f\n", proven.gouging, gouge->rapid ? 1 : 0, gouge->pose.tip.x,
                gouge->pose.tip.y, gouge->pose.tip.z);
  std::fflush(stdout);
}

}  // namespace

int prove_command(const ProveOptions& options) {
  // Who tells it that the program is whole has started it, and wants no proof without living on.
  if (options.told) ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const std::string& name = options.name.empty() ? options.program : options.name;
  const auto jobs = config::load_operations(options.job, {.stl = options.stl,
                                                          .machine = options.machine,
                                                          .operation = options.operation,
                                                          .closed = options.closed});
  if (!jobs) return report(jobs.error());
  std::vector<config::NamedFile> inputs;
  for (const config::Job& one : *jobs)
    for (const config::NamedFile& file : config::files_of(one)) inputs.push_back(file);
  inputs.push_back({"PROGRAM", options.program});
  if (const auto fits = config::check_outputs({{"--picture", options.picture}}, inputs); !fits)
    return report(fits.error());
  const auto show = [&](double share) {
    if (options.progress) std::printf("progress %.3f\n", share), std::fflush(stdout);
    return true;
  };
  config::PartsByTolerance parts;
  std::deque<Prover> provers;
  std::deque<CollisionCheck> checks;
  std::vector<OperationProof> held;
  for (const config::Job& one : *jobs) {
    const auto part = parts.of(one, [&](double share) { return show(kChecked * share); });
    if (!part) return report(part.error());
    auto check = CollisionCheck::make(**part, one);
    if (!check) return report(check.error());
    provers.emplace_back(**part, one);
    checks.push_back(std::move(*check));
    held.push_back({&provers.back(), checks.back().idle() ? nullptr : &checks.back()});
  }
  show(kReady);
  std::string word;
  if (options.told && !std::getline(std::cin, word)) return report({Code::kCancelled, "no program came"});
  std::ifstream in(options.program, std::ios::binary);
  if (!in) return report({Code::kIo, name + ": cannot be opened"});
  const int threads = options.threads > 0
                          ? options.threads
                          : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const auto proven = prove_program(in, name, *jobs, held, threads,
                                    [&](double share) { return show(kReady + (kHeld - kReady) * share); });
  if (!proven) return report(proven.error());
  const auto& gouge = proven->proof.deepest;
  if (options.told && (gouge || !proven->collisions.places.empty())) tell_places(*proven);
  if (!gouge && !proven->collisions.places.empty())
    return report({Code::kInput, checks[proven->colliding].text(proven->collisions, name)});
  if (!gouge) {
    const auto first = parts.of(jobs->front());
    if (!first) return report(first.error());
    const auto rapid = find_rapid_in_stock(options.program, *jobs, **first, threads,
                                           [&](double share) { return show(kHeld + (1.0 - kHeld) * share); });
    if (!rapid && rapid.error().code == Code::kCancelled) return report(rapid.error());
    if (rapid && *rapid)
      return report(
          {Code::kInput, stock_text(**rapid, words_at(in, (*rapid)->worst.line), name, jobs->front())});
    std::printf("proven %llu moves, largest gouge %.4f mm\n",
                static_cast<unsigned long long>(proven->proof.moves), proven->proof.gouge);
    std::printf("%s\n", checks.front().scope().c_str());
    if (!rapid) std::printf("rapids are not held against the stock: %s\n", rapid.error().message.c_str());
    return kDone;
  }
  const config::Job& gouging = (*jobs)[proven->gouging];
  if (const auto part = parts.of(gouging); part && !options.picture.empty())
    if (auto drawn = draw(in, name, *jobs, gouging, **part, *gouge, options.picture); !drawn)
      report(drawn.error());
  return report({Code::kInput, gouge_text(*gouge, words_at(in, gouge->line), name, gouging)});
}

}  // namespace tiltfeed::sim
