#pragma once
// XML element by element (expat): names and attributes with their namespaces' addresses before a '|'.

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::pathgen {

class XmlAttributes {
 public:
  explicit XmlAttributes(const char** list) : list_(list) {}
  /// Null where it is not there.
  const char* find(std::string_view name) const;

 private:
  const char** list_;
};

struct XmlHandlers {
  std::function<Result<void>(std::string_view name, const XmlAttributes& attributes)> begin;
  std::function<Result<void>(std::string_view name)> end;
  std::function<void(std::string_view prefix, std::string_view address)> names_space = {};
};

/// Errors: kInput with the line: text that is no XML, a document type (3MF has none, and entities are how
/// small files become large), nesting over 100; those of the handlers, with the line in front.
Result<void> walk_xml(std::string_view text, const std::string& file, const XmlHandlers& handlers);

}  // namespace tiltfeed::pathgen
