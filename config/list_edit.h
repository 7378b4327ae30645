#pragma once
// Items of a list added, moved and taken out where they stand: remarks and all else stay as they are.

#include <cstddef>
#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::config {

// `list` is a key of the file's root whose value is a list. Items count from 1. In a list by indents an item
// has the remarks right above it, at its own indent. Properties: the result reads as the text did but for the
// list's items and their order. Errors: kInput: the text is no YAML; there is no such list or item; it is
// written in a way that only a person can change.

/// A copy of item `number` right behind it; the remarks above it are not copied.
Result<std::string> item_copied(const std::string& text, const std::string& list, std::size_t number);
/// Item `from` at the place `to`, with its remarks.
Result<std::string> item_moved(const std::string& text, const std::string& list, std::size_t from,
                               std::size_t to);
/// Without item `number`, whose lines stay as remarks where it has lines of its own. Errors also: it is the
/// only item.
Result<std::string> item_taken_out(const std::string& text, const std::string& list, std::size_t number);

}  // namespace tiltfeed::config
