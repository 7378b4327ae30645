#include "tests/attack/proof_judge.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <sstream>

#include "daemon/post/block.h"
#include "sim/control/control_reader.h"
#include "sim/proof/program_proof.h"
#include "tests/attack/dice.h"
#include "tests/judges/tool_proof.h"

namespace tiltfeed::attack {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

/// Of the tolerance: what the proof and depths at poses may differ by.
constexpr double kBound = 0.05;
/// Moves of a case that are damaged, and by how much (tolerances).
constexpr int kDamaged = 8;
/// Poses at which a move is looked at, and how often again so many round the deepest.
constexpr int kPlaces = 48, kRounds = 4;
/// The control's own moves to the first pose: over it, and down.
constexpr std::uint64_t kApproachBlocks = 2;
/// Poses of a tool that is drawn out, in its diameters.
constexpr double kDrawnOut = 0.1;
constexpr double kLeastDamage = 0.3, kMostDamage = 40.0;

class ProofJudge {
 public:
  ProofJudge(const Job& job, const CheckedMesh& part, const JointPath& joints)
      : job_(job),
        joints_(joints),
        tolerance_(job.plan.tolerance),
        bounds_(part.bounds),
        prover_(part, job),
        surface_(part.mesh),
        tool_(job.plan.cutter, {job.plan.allowance, job.plan.radial_stock, job.plan.axial_stock}) {
    if (job.plan.fixtures) fixtures_.emplace(job.plan.fixtures->mesh);
  }

  ProofVerdict run(double deepest) {
    hold_text(deepest);
    Dice dice(joints_.moves.size());
    for (int i = 0; i < kDamaged && joints_.moves.size() > 2; ++i) hold_damaged(dice);
    return std::move(verdict_);
  }

 private:
  void finding(const char* what, double proven, double at_poses, const std::string& where) {
    char text[160];
    std::snprintf(text, sizeof text, "%s: %.4f mm by the proof, %.4f mm at poses (tolerance %g) at ", what,
                  proven, at_poses, tolerance_);
    verdict_.findings.push_back(text + where);
  }

  double depth(const Pose& pose) const {
    double most = 0.0;
    for (const sim::ToolPart part : sim::kToolParts)
      if (const sim::Hit hit = tool_.clearance(surface_, pose, part, -most); hit.facet != kNoFacet)
        most = -hit.value;
    return most;
  }

  /// Of a move, at kPlaces and closer and closer round the deepest of them: from below.
  double depth(const sim::ProgramMove& move, Pose& worst) const {
    double most = 0.0, low = 0.0, high = 1.0, at = 0.0;
    for (int round = 0; round < kRounds; ++round) {
      const double step = (high - low) / kPlaces;
      for (int k = 0; k <= kPlaces; ++k) {
        const Pose pose = prover_.frames().pose(move, low + step * k);
        if (const double here = depth(pose); here > most) most = here, worst = pose, at = low + step * k;
      }
      low = std::max(0.0, at - step), high = std::min(1.0, at + step);
    }
    return most;
  }

  /// What the proof says of moves whose deepest pose is known from below. `told`: the move that it refuses.
  void compare(const sim::Proof& proof, double deepest, const std::string& where,
               const sim::ProgramMove* told) {
    const double bound = kBound * tolerance_;
    if (proof.deepest) {
      Pose worst = proof.deepest->pose;
      const double there = std::max(depth(worst), depth(*told, worst));
      if (there < proof.deepest->depth - bound)
        finding("proof tells too deep a gouge", proof.deepest->depth, there, pasteable(worst));
    } else if (deepest > tolerance_ + bound) {
      finding("proof misses a gouge", proof.gouge, deepest, where);
    } else if (deepest > proof.gouge + bound) {
      finding("proof understates", proof.gouge, deepest, where);
    }
  }

  void hold_text(double deepest) {
    std::stringstream text;
    if (const auto written = write_program(joints_, job_, text); !written)
      return verdict_.findings.push_back("post: " + written.error().message);
    const auto proven =
        sim::prove_program(text, "case.nc", std::span(&job_, 1), {{&prover_, nullptr}}, 1, {});
    if (!proven) return verdict_.findings.push_back("proof cannot read: " + proven.error().message);
    verdict_.moves = proven->proof.moves;
    if (proven->inside) return;  // told by the depth of the tip, not by facets
    const auto& gouge = proven->proof.deepest;
    if (!gouge) return compare(proven->proof, deepest, "the program", nullptr);
    text.clear(), text.seekg(0);
    const sim::ProgramMove told = move_of(text, gouge->block);
    compare(proven->proof, deepest, "the program", &told);
    Pose worst = gouge->pose;
    const double there = depth(told, worst);
    const bool retracts = gouge->rapid && gouge->block > joints_.moves.size();
    const bool approaches = gouge->rapid && gouge->block <= kApproachBlocks;
    const bool is_below = dot(gouge->pose.axis, job_.plan.up) < 0.0;
    if (retracts && is_below && verdict_.findings.empty())
      verdict_.refusal = "the retract from below the part is in it";
    else if (approaches && is_below && verdict_.findings.empty())
      verdict_.refusal = "the approach from below the part is through it";
    else if (approaches && is_shut_in(told, 1.0) && verdict_.findings.empty())
      verdict_.refusal = "the part is in every way in to the first pose";
    else if (retracts && is_shut_in(told, 0.0) && verdict_.findings.empty())
      verdict_.refusal = "the part is in every way out from the last pose";
    else
      finding("gouge", gouge->depth, there, pasteable(worst));
  }

  /// Does the tool come nearer to a fixture than it is to keep off?
  bool is_at_fixture(const Pose& pose) const {
    if (!fixtures_) return false;
    const FixtureRoom& room = job_.plan.fixture_room;
    const std::array off{room.cutter, room.shank, room.holder};
    for (std::size_t i = 0; i < off.size(); ++i)
      if (tool_.clearance(*fixtures_, pose, sim::kToolParts[i], off[i]).facet != kNoFacet) return true;
    return false;
  }

  /// Do part or fixtures stand in the way of a tool that is drawn out along its axis from that share of the
  /// move? A rapid may not even graze it.
  bool is_shut_in(const sim::ProgramMove& move, double share) const {
    const Pose end = prover_.frames().pose(move, share);
    const double step = kDrawnOut * job_.plan.cutter.diameter;
    for (double out = 0.0; out < distance(bounds_.min, bounds_.max); out += step)
      if (const Pose there{end.tip + end.axis * out, end.axis}; depth(there) > 0.0 || is_at_fixture(there))
        return true;
    return false;
  }

  /// The move of a block, counted from 1 as the proof does.
  sim::ProgramMove move_of(std::istream& text, std::uint64_t block) const {
    sim::ControlReader reader(job_.machine, job_.setup);
    sim::ProgramMove move;
    std::uint64_t count = 0;
    const auto read = sim::read_control_program(text, "case.nc", reader, [&](const sim::ControlBlock& one) {
      const bool moves = one.block.op == sim::Op::kRapid || one.block.op == sim::Op::kFeed;
      if (!moves || count == block) return;
      ++count;
      move.from = move.to, move.to = one.block.target, move.tcp = one.tcp;
    });
    return move;
  }

  /// One end between two moves is somewhere else.
  void hold_damaged(Dice& dice) {
    const std::size_t at = 1 + dice.below(joints_.moves.size() - 2);
    Joints damaged = joints_.moves[at].joints;
    const Vec3 by = dice.direction() * (tolerance_ * dice.spread(kLeastDamage, kMostDamage));
    damaged.x += by.x, damaged.y += by.y, damaged.z += by.z;
    const Joints &before = joints_.moves[at - 1].joints, &after = joints_.moves[at + 1].joints;
    const std::array moves{sim::ProgramMove{before, damaged, false, false, 1, 1},
                           sim::ProgramMove{damaged, after, false, false, 2, 2}};
    Pose worst;
    double deepest = depth(moves[0], worst);
    if (const double next = depth(moves[1], worst); next > deepest) deepest = next;
    const sim::Proof proof = prover_.hold(moves);
    ++verdict_.damaged, verdict_.refused += proof.deepest ? 1 : 0;
    const sim::ProgramMove* told = proof.deepest ? &moves[proof.deepest->block - 1] : nullptr;
    compare(proof, deepest, pasteable(worst) + ", damaged move " + std::to_string(at), told);
  }

  const Job& job_;
  const JointPath& joints_;
  double tolerance_;
  Box bounds_;
  sim::Prover prover_;
  sim::PartDistance surface_;
  sim::ToolSolid tool_;
  std::optional<sim::PartDistance> fixtures_;
  ProofVerdict verdict_;
};

}  // namespace

ProofVerdict judge_proof(const Job& job, const CheckedMesh& part, const JointPath& joints, double deepest) {
  return ProofJudge(job, part, joints).run(deepest);
}

}  // namespace tiltfeed::attack
