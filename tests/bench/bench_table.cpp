#include "tests/bench/bench_table.h"

#include <cmath>
#include <fstream>
#include <limits>

#include "tests/bench/markdown.h"

namespace tiltfeed::bench {

namespace {

constexpr const char* kShare = "% ";

}  // namespace

std::string share_name(int order, const std::string& stage) {
  return kShare + std::string(1, static_cast<char>('A' + order)) + stage;
}

void BenchTable::ReportRuns(const std::vector<Run>& runs) {
  for (const Run& run : runs) {
    failed_ = failed_ || (run.error_occurred && !run.error_message.starts_with(kSkipped));
    const bool result =
        run.run_type == Run::RT_Aggregate ? run.aggregate_name == "median" : run.repetitions == 1;
    if (!result || run.error_occurred) continue;
    const double unit = GetTimeUnitMultiplier(run.time_unit);
    Entry entry{run.run_name.function_name,
                run.GetAdjustedRealTime() / unit,
                run.GetAdjustedCPUTime() / unit,
                {},
                {}};
    for (const auto& [name, counter] : run.counters) entry.counters[name] = counter.value;
    entries_.push_back(std::move(entry));
  }
  // The console shows names and times; the counters are for the table.
  std::vector<Run> plain = runs;
  for (Run& run : plain) run.counters.clear();
  ConsoleReporter::ReportRuns(plain);
}

void BenchTable::add_rows(const std::string& file) {
  std::ifstream in(file);
  for (std::string name, seconds, remark;
       std::getline(in, name, '\t') && std::getline(in, seconds, '\t') && std::getline(in, remark);)
    entries_.push_back({name, std::stod(seconds), std::nan(""), {}, remark});
}

double BenchTable::Entry::at(const std::string& counter) const {
  const auto found = counters.find(counter);
  return found == counters.end() ? std::numeric_limits<double>::quiet_NaN() : found->second;
}

double BenchTable::exponent(const std::string& series, const std::string& base,
                            const std::string& counter) const {
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (const Entry& e : entries_) {
    if (!e.name.starts_with(series)) continue;
    const double x = std::log(e.at(base)), y = std::log(e.at(counter));
    n += 1.0, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  if (n < 3.0) return std::numeric_limits<double>::quiet_NaN();
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

std::string BenchTable::remark(const Entry& e) {
  std::string text = e.remark;
  const auto say = [&](const std::string& piece) { text += (text.empty() ? "" : ", ") + piece; };
  if (e.has("fixed_points")) {
    say("5-axis / 3-axis " + formatted("%.3f", e.at("ratio")) + " (processor " +
        formatted("%.3f", e.at("processor_ratio")) + ")");
    say("3-axis: side step " + formatted("%.4f", e.at("fixed_side_step")) + " mm, " +
        grouped(e.at("fixed_points")) + " points, " + grouped(e.at("fixed_envelope_points")) +
        " before thinning");
  } else if (e.has("z_map_s")) {
    say("ours / bare z-map " + formatted("%.2f", e.at("ratio")) + " (processor " +
        formatted("%.2f", e.at("processor_ratio")) + "): z-map of " + grouped(e.at("z_map_columns")) +
        " columns " + formatted("%.3f", e.at("z_map_s")) + " s");
  } else if (e.has("ratio")) {
    say("1 thread / 2 threads " + formatted("%.2f", e.at("ratio")) + " (processor " +
        formatted("%.2f", e.at("processor_ratio")) + "); the machine itself " +
        formatted("%.2f", e.at("machine_ratio")));
  }
  if (e.has("columns"))
    say("height map of " + grouped(e.at("columns")) + " columns " + formatted("%.3f", e.processor_seconds) +
        " s; ours without read and check " + formatted("%.3f", e.at("ours_s")) +
        " s: " + formatted("%.2f", e.at("ours_s") / e.processor_seconds) + " times");
  if (e.has("bytes")) say(grouped(e.at("bytes")) + " bytes read, one pass");
  if (e.has("directions"))
    say("directions sought at " + grouped(e.at("cl_points")) + " CL points, " + grouped(e.at("directions")) +
        " tested: " + grouped(e.at("directions") / e.at("processor_s")) + " in a second of processor time");
  if (e.has("side_step")) say("side step " + formatted("%.5f", e.at("side_step")) + " mm");
  if (e.has("envelope_points")) say(grouped(e.at("envelope_points")) + " before thinning");
  for (const auto& [name, value] : e.counters)
    if (name.starts_with(kShare)) say(name.substr(share_name(0, "").size()) + formatted(" %.0f %%", value));
  return text;
}

std::vector<std::string> BenchTable::cells(const Entry& e) {
  const auto number = [](double value, const char* format) {
    return std::isfinite(value) ? format == nullptr ? grouped(value) : formatted(format, value)
                                : std::string();
  };
  const double wall = e.has("wall_s") ? e.at("wall_s") : e.seconds;
  const double processor = e.has("wall_s") ? e.at("processor_s") : e.processor_seconds;
  const double facets = e.at("facets");
  return {e.name,
          number(wall, wall < 0.1 ? "%.5f" : "%.3f"),
          number(processor, processor < 0.1 ? "%.5f" : "%.3f"),
          number(facets, nullptr),
          number(e.at("points"), nullptr),
          number(processor / e.at("points") * 1e9, nullptr),
          number(processor / facets * 1e9, nullptr),
          number(e.at("peak_bytes") / facets, nullptr),
          remark(e)};
}

std::string BenchTable::markdown() const {
  MarkdownTable table(
      {"name", "wall s", "processor s", "facets", "points", "ns/point", "ns/facet", "peak B/facet", "more"});
  for (const Entry& entry : entries_) table.add(cells(entry));
  const auto add_exponents = [&](const std::string& series, const std::string& base) {
    const double time = exponent(series, base, "processor_s"), memory = exponent(series, base, "peak_bytes");
    if (!std::isfinite(time)) return;
    table.add({series + "*", "", "", "", "", "", "", "",
               "fitted: processor time ~ " + base + "^" + formatted("%.2f", time) + ", peak memory ~ " +
                   base + "^" + formatted("%.2f", memory)});
  };
  add_exponents("facets/", "facets");
  add_exponents("points/", "points");
  add_exponents("free_step/", "points");
  return table.text();
}

}  // namespace tiltfeed::bench
