#pragma once
// Collects what Google Benchmark reports (the median of the repetitions) and writes it as one table.

#include <benchmark/benchmark.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace tiltfeed::bench {

/// Name of a counter that holds a stage's share in percent; they are shown in order.
std::string share_name(int order, const std::string& stage);
/// A benchmark that stops with a message that starts so has not failed.
inline constexpr const char* kSkipped = "skipped";

class BenchTable : public benchmark::ConsoleReporter {
 public:
  BenchTable() : ConsoleReporter(OO_Tabular) {}
  void ReportRuns(const std::vector<Run>& runs) override;
  /// From a file of lines: name, seconds, remark, with tabs between.
  void add_rows(const std::string& file);
  bool failed() const { return failed_; }
  std::string markdown() const;

 private:
  struct Entry {
    std::string name;
    double seconds = 0.0, processor_seconds = 0.0;  ///< of one iteration
    std::map<std::string, double> counters;
    std::string remark;
    double at(const std::string& counter) const;
    bool has(const std::string& counter) const { return counters.contains(counter); }
  };
  static std::vector<std::string> cells(const Entry& entry);
  static std::string remark(const Entry& entry);
  /// Slope of log(counter) over log(base) of the benchmarks whose name starts with `series`; NaN with fewer
  /// than three.
  double exponent(const std::string& series, const std::string& base, const std::string& counter) const;

  std::vector<Entry> entries_;
  bool failed_ = false;
};

}  // namespace tiltfeed::bench
