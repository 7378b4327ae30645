#pragma once
// Resolved settings as text for people and logs: one `key: value` a line, in the order given.

#include <string>

#include "kinematics/basics/geometry.h"
#include "kinematics/basics/units.h"

namespace tiltfeed::config {

/// The shortest decimal text that reads back as exactly this value; never an exponent, never "-0".
std::string exact_text(double value);

/// "[x, y, z]", each as exact_text() has it.
std::string vector_text(Vec3 v);

/// Rounded to nine decimals: what the conversion of units adds is not shown.
double tidy(double value);

class Description {
 public:
  void add(const std::string& key, const std::string& value) { text_ += key + ": " + value + "\n"; }
  void add(const std::string& key, const char* value) { add(key, std::string(value)); }
  void add(const std::string& key, double value) { add(key, exact_text(value)); }
  void add(const std::string& key, Angle value) { add(key, tidy(value.degrees())); }
  void add(const std::string& key, bool value) { add(key, value ? "true" : "false"); }
  void add(const std::string& key, int value) { add(key, std::to_string(value)); }
  void add(const std::string& key, Vec3 v) { add(key, vector_text(v)); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace tiltfeed::config
