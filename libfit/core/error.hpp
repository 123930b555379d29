#pragma once

#include <exception>
#include <string>
#include <utility>

namespace palpate {

/// Bad input or surroundings: what the user must read to put it right.
/// where: file and line, data-set path, scene key or option. what: the fact. remedy: one sentence.
/// Thrown by every reader and by every check of what a user gave; caught in `main` alone.
/// A number that did not work out (no convergence, a poor fit) is a status in a result, never this.
class Error : public std::exception {
 public:
  Error(std::string where, std::string what, std::string remedy)
      : where_(std::move(where)),
        what_(std::move(what)),
        remedy_(std::move(remedy)),
        message_(where_ + ": " + what_ + "\n  " + remedy_) {}

  const std::string& where() const noexcept { return where_; }
  const std::string& fact() const noexcept { return what_; }
  const std::string& remedy() const noexcept { return remedy_; }

  /// "WHERE: WHAT" and, on a second line indented by two, the remedy.
  const char* what() const noexcept override { return message_.c_str(); }

 private:
  std::string where_, what_, remedy_, message_;
};

}  // namespace palpate
