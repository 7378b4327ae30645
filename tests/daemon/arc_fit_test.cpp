// Arcs for straight blocks: brute force on the printed words, by a geometry of its own (a place is turned
// round the centre by complex numbers).

#include "daemon/post/arc_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/samples.h"
#include "tests/texts/dialect_posting.h"

namespace tiltfeed {
namespace {

constexpr double kArcFeed = 1200.0;  // mm/min
constexpr double kPi = std::numbers::pi;
using Turned = std::complex<double>;

/// Words of a path at one feed, as they are printed; the first block is a rapid.
JointPath path_of(const std::vector<Joints>& places, const ProgramFormat& format) {
  JointPath path;
  for (const Joints& place : places) {
    Joints at = place;
    for (double Joints::*one : {&Joints::x, &Joints::y, &Joints::z}) at.*one = printed_place(format, at.*one);
    if (path.moves.empty()) {
      path.moves.push_back({at, 0.0, MoveKind::kRapid, 0});
      continue;
    }
    const Joints& from = path.moves.back().joints;
    if (at == from) continue;
    const double way = std::hypot(at.x - from.x, at.y - from.y, at.z - from.z);
    path.moves.push_back({at, std::max(way, 1e-6) * 60.0 / kArcFeed, MoveKind::kCut,
                          static_cast<std::uint32_t>(path.moves.size())});
  }
  return path;
}

/// A place by its plane's axes.
Joints in_plane(int plane, double first, double second, double third) {
  Joints at{0, 0, 0, 12.5, -40};
  const ArcAxes axes = arc_axes(plane);
  at.*axes.first = first, at.*axes.second = second, at.*axes.third = third;
  return at;
}

double apart(const Joints& p, const Joints& q) { return std::hypot(p.x - q.x, p.y - q.y, p.z - q.z); }

double to_segment(const Joints& p, const Joints& a, const Joints& b) {
  const double dx = b.x - a.x, dy = b.y - a.y, dz = b.z - a.z, square = dx * dx + dy * dy + dz * dz;
  const double t =
      square > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy + (p.z - a.z) * dz) / square, 0.0, 1.0)
                 : 0.0;
  return apart(p, {a.x + t * dx, a.y + t * dy, a.z + t * dz, 0, 0});
}

/// Places along an arc, some of them: start and end too.
std::vector<Joints> sampled(const Joints& from, const Joints& to, const PrintedArc& arc, int count) {
  const ArcAxes axes = arc_axes(arc.plane);
  const Turned centre{from.*axes.first + arc.first, from.*axes.second + arc.second};
  const Turned begin = Turned{from.*axes.first, from.*axes.second} - centre,
               end = Turned{to.*axes.first, to.*axes.second} - centre;
  double turn = std::arg(end / begin);
  if (arc.clockwise && turn > 0) turn -= 2 * kPi;
  if (!arc.clockwise && turn < 0) turn += 2 * kPi;
  std::vector<Joints> places;
  for (int i = 0; i <= count; ++i) {
    const double f = static_cast<double>(i) / count;
    const Turned at = centre + std::polar(std::abs(begin) + f * (std::abs(end) - std::abs(begin)),
                                          std::arg(begin) + f * turn);
    Joints place = from;
    place.*axes.first = at.real(), place.*axes.second = at.imag();
    places.push_back(place);
  }
  return places;
}

double to_path(const Joints& p, const std::vector<Joints>& path) {
  double least = 1e9;
  for (std::size_t i = 1; i < path.size(); ++i) least = std::min(least, to_segment(p, path[i - 1], path[i]));
  return least;
}

/// All properties of a fit, by brute force. Returns the number of arcs.
std::size_t expect_sound(const JointPath& path, const ArcFit& fit, const ProgramFormat& format,
                         double tolerance) {
  std::vector<Joints> before, after;
  for (const JointMove& move : path.moves) before.push_back(move.joints);
  after.push_back(fit.words.moves.front().joints);
  double seconds = 0.0, stated = 0.0;
  std::size_t stands_for = 0, arc = 0;
  for (std::size_t i = 1; i < fit.words.moves.size(); ++i) {
    const Joints &from = fit.words.moves[i - 1].joints, &to = fit.words.moves[i].joints;
    seconds += fit.words.moves[i].seconds;
    if (arc == fit.arcs.size() || fit.arcs[arc].block != i) {
      ++stands_for;
      after.push_back(to);
      continue;
    }
    const PrintedArc& one = fit.arcs[arc++];
    stands_for += one.stands_for;
    const ArcAxes axes = arc_axes(one.plane);
    EXPECT_EQ(from.*axes.third, to.*axes.third);
    EXPECT_EQ(from.a, to.a);
    EXPECT_EQ(from.c, to.c);
    EXPECT_EQ(printed_place(format, one.first), one.first);
    EXPECT_EQ(printed_place(format, one.second), one.second);
    const double radius = std::hypot(one.first, one.second),
                 end = std::hypot(to.*axes.first - from.*axes.first - one.first,
                                  to.*axes.second - from.*axes.second - one.second);
    EXPECT_LE(std::abs(end - radius), kMostArcRadiusError);
    EXPECT_LE(one.length / radius * 180.0 / kPi, kMostArcTurn + 0.1);
    const std::vector<Joints> places = sampled(from, to, one, 400);
    double way = 0.0, height = 0.0;
    for (std::size_t k = 1; k < places.size(); ++k) {
      way += apart(places[k - 1], places[k]);
      height = std::max(height, to_segment(places[k], from, to));
      EXPECT_LE(to_path(places[k], before), tolerance + 1e-9) << "arc " << arc;
    }
    EXPECT_GT(height, 0.99 * tolerance) << "a straight line would do";
    EXPECT_NEAR(way, one.length, 1e-3 * way);
    after.insert(after.end(), places.begin() + 1, places.end());
  }
  EXPECT_EQ(arc, fit.arcs.size());
  EXPECT_LE(stands_for, path.moves.size() - 1);
  for (const JointMove& move : path.moves) stated += move.seconds;
  EXPECT_NEAR(seconds, stated, 2e-2 * stated);
  for (std::size_t i = 1; i < before.size(); ++i)
    for (const double f : {0.25, 0.5, 1.0}) {
      const Joints &p = before[i - 1], &q = before[i];
      const Joints at{p.x + f * (q.x - p.x), p.y + f * (q.y - p.y), p.z + f * (q.z - p.z), 0, 0};
      EXPECT_LE(to_path(at, after), tolerance + 1e-3) << "block " << i;  // the chords of 400
    }
  EXPECT_LE(apart(fit.words.moves.back().joints, before.back()), tolerance);
  return arc;
}

ProgramFormat format_of(Dialect dialect) { return usual_format(dialect); }
const std::vector<FeedChange> kOneFeed;
const std::vector<PathEvent> kNoEvent;

/// Round a centre, in steps that leave the circle by `chord`.
void go_round(std::vector<Joints>& places, int plane, Turned centre, double radius, double begin, double turn,
              double third, double chord) {
  const int steps = std::max(3, static_cast<int>(std::ceil(std::abs(turn) / std::sqrt(8 * chord / radius))));
  for (int i = 0; i <= steps; ++i) {
    const Turned at = centre + std::polar(radius, begin + turn * i / steps);
    places.push_back(in_plane(plane, at.real(), at.imag(), third));
  }
}

TEST(ArcFit, ACircleIsThreeArcs) {
  const ProgramFormat format = format_of(Dialect::kRs274);
  for (const int plane : {17, 18, 19})
    for (const double way : {1.0, -1.0}) {
      SCOPED_TRACE(std::to_string(plane) + (way > 0 ? " anticlockwise" : " clockwise"));
      std::vector<Joints> places;
      go_round(places, plane, {7, -3}, 20, 0.3, way * 2 * kPi, 5, 0.001);
      const JointPath path = path_of(places, format);
      const ArcFit fit = fit_arcs(path, {kOneFeed, kNoEvent}, format, 0.002);
      EXPECT_EQ(expect_sound(path, fit, format, 0.002), 3u);
      EXPECT_EQ(fit.words.moves.size(), 4u);
      for (const PrintedArc& arc : fit.arcs) {
        EXPECT_EQ(arc.plane, plane);
        EXPECT_EQ(arc.clockwise, way < 0);
      }
      EXPECT_EQ(fit.words.moves.back().joints, path.moves.back().joints);
      EXPECT_EQ(fit.words.moves.back().move, path.moves.back().move);
    }
}

TEST(ArcFit, WhereAControlHasOnePlaneOthersStayStraight) {
  for (const DialectName& one : kDialects) {
    const ProgramFormat format = format_of(one.dialect);
    for (const int plane : {17, 18, 19}) {
      std::vector<Joints> places;
      go_round(places, plane, {7, -3}, 20, 0.3, 1.0, 5, 0.001);
      const ArcFit fit = fit_arcs(path_of(places, format), {kOneFeed, kNoEvent}, format, 0.003);
      const bool one_plane = one.dialect == Dialect::kSiemens || one.dialect == Dialect::kHeidenhain ||
                             one.dialect == Dialect::kHeidenhainIso;
      EXPECT_EQ(fit.arcs.size(), one_plane && plane != 17 ? 0u : 1u) << one.name << " " << plane;
    }
  }
}

TEST(ArcFit, LinesBetweenRoundedCornersStay) {
  const ProgramFormat format = format_of(Dialect::kFanuc);
  std::vector<Joints> places{in_plane(17, 0, 5, 1)};
  const Turned corners[] = {{5, 45}, {75, 45}, {75, 5}, {5, 5}};
  for (int k = 0; k < 4; ++k) go_round(places, 17, corners[k], 5, kPi - k * kPi / 2, -kPi / 2, 1, 0.001);
  const JointPath path = path_of(places, format);
  const ArcFit fit = fit_arcs(path, {kOneFeed, kNoEvent}, format, 0.003);
  EXPECT_EQ(expect_sound(path, fit, format, 0.003), 4u);
  EXPECT_EQ(fit.words.moves.size(), 9u) << "four arcs, four lines";
}

TEST(ArcFit, WhatIsNoArcStaysAsItIs) {
  const ProgramFormat format = format_of(Dialect::kRs274);
  const auto untouched = [&](const std::vector<Joints>& places, const char* what) {
    const JointPath path = path_of(places, format);
    const ArcFit fit = fit_arcs(path, {kOneFeed, kNoEvent}, format, 0.002);
    EXPECT_EQ(fit.arcs.size(), 0u) << what;
    ASSERT_EQ(fit.words.moves.size(), path.moves.size()) << what;
    for (std::size_t i = 0; i < path.moves.size(); ++i)
      EXPECT_EQ(fit.words.moves[i].joints, path.moves[i].joints) << what;
  };
  std::vector<Joints> helix, turning, line, zigzag, speck;
  for (int i = 0; i < 60; ++i) {
    const double f = i * 0.05;
    helix.push_back(in_plane(17, 20 * std::cos(f), 20 * std::sin(f), 0.01 * i));
    turning.push_back(in_plane(17, 20 * std::cos(f), 20 * std::sin(f), 5));
    turning.back().c += 0.5 * i;
    line.push_back(in_plane(17, 0.5 * i, 0.25 * i + 1e-4 * (i % 2), 5));
    speck.push_back(in_plane(17, 0.02 * std::cos(f), 0.02 * std::sin(f), 5));
    zigzag.push_back(in_plane(17, 0.5 * i, i % 2, 5));
  }
  untouched(helix, "a helix");
  untouched(turning, "a rotary turns");
  untouched(line, "a line with rounded places");
  untouched(zigzag, "corners");
  untouched(speck, "a circle that a control may take for none");
}

TEST(ArcFit, NoArcGoesAcrossAFeedAnEventOrAnotherKind) {
  const ProgramFormat format = format_of(Dialect::kGrbl);
  std::vector<Joints> places;
  go_round(places, 17, {0, 0}, 20, 0, kPi / 2, 5, 0.001);
  const JointPath path = path_of(places, format);
  const std::size_t whole = fit_arcs(path, {kOneFeed, kNoEvent}, format, 0.002).arcs.size();
  EXPECT_EQ(whole, 1u);
  const auto middle = static_cast<std::uint32_t>(path.moves.size() / 2);
  const std::vector<FeedChange> feeds{{0, Feed::from_mm_per_min(kArcFeed)},
                                      {middle, Feed::from_mm_per_min(600)}};
  const std::vector<PathEvent> events{{middle, EventKind::kDwell, 1.0, ""}};
  JointPath plunge = path, slower = path;
  for (std::size_t i = 1; i < middle; ++i) plunge.moves[i].kind = MoveKind::kPlunge;
  for (std::size_t i = 1; i < middle; ++i) slower.moves[i].seconds *= 1.5;
  for (const ArcFit& fit :
       {fit_arcs(path, {feeds, kNoEvent}, format, 0.002), fit_arcs(path, {kOneFeed, events}, format, 0.002),
        fit_arcs(plunge, {kOneFeed, kNoEvent}, format, 0.002),
        fit_arcs(slower, {kOneFeed, kNoEvent}, format, 0.002)}) {
    ASSERT_EQ(fit.arcs.size(), 2u);
    EXPECT_EQ(fit.words.moves[fit.arcs[0].block].move, middle - 1);
  }
}

/// Lines and bows of any size, in any plane, with noise, in the decimals of any dialect and unit.
TEST(ArcFit, RandomPathsKeepAllProperties) {
  std::size_t arcs = 0, saved = 0;
  for (unsigned seed = 1; seed <= unsigned{samples(150)}; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto any = [&](double from, double to) {
      return std::uniform_real_distribution<double>(from, to)(random);
    };
    ProgramFormat format = format_of(kDialects[seed % kDialects.size()].dialect);
    if (seed % 5 == 0 && format.dialect == Dialect::kFanuc) format.inches = true, format.linear_decimals = 4;
    const double tolerance = any(0.0005, 0.02), noise = any(0.0, tolerance);
    const int plane = 17 + static_cast<int>(seed % 3);
    std::vector<Joints> places{in_plane(plane, any(-50, 50), any(-50, 50), 4)};
    const ArcAxes axes = arc_axes(plane);
    for (int piece = 0; piece < 6; ++piece) {
      const Joints last = places.back();
      const Turned from{last.*axes.first, last.*axes.second};
      if (seed % 2 == static_cast<unsigned>(piece % 2)) {
        places.push_back(in_plane(plane, from.real() + any(-20, 20), from.imag() + any(-20, 20), 4));
        continue;
      }
      const double radius = std::exp(any(-1.0, 5.0)), angle = any(-kPi, kPi), turn = any(-5.5, 5.5);
      go_round(places, plane, from - std::polar(radius, angle), radius, angle, turn, 4,
               any(0.1, 1.5) * tolerance);
    }
    for (Joints& at : places)
      for (double Joints::*one : {axes.first, axes.second, axes.third}) at.*one += any(-noise, noise) / 4;
    const JointPath path = path_of(places, format);
    const ArcFit fit = fit_arcs(path, {kOneFeed, kNoEvent}, format, tolerance);
    arcs += expect_sound(path, fit, format, tolerance);
    saved += path.moves.size() - fit.words.moves.size();
  }
  EXPECT_GT(arcs, std::size_t{samples(400)});
  EXPECT_GT(saved, std::size_t{samples(4000)});
  RecordProperty("arcs", static_cast<int>(arcs));
}

}  // namespace
}  // namespace tiltfeed
