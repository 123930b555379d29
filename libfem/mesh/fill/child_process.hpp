#pragma once

#include <functional>
#include <string>
#include <variant>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Runs a mesher in a forked child that is watched, because meshers crash, abort and loop.
/// Returns its mesh, or why there is none: "stopped on signal 11 (segmentation fault)", or what
/// `mesher` threw: what would come again on any machine. What only this machine at this hour knows
/// must not choose between settings, so it throws Error: the safety limit, no memory, a child that
/// was killed or could not be started. `thrown_int` puts a thrown int into words. The child only
/// calls `mesher`, writes its mesh into anonymous memory and leaves through _exit: no destructor,
/// exit handler or stream of the parent runs twice. Other threads do not exist in the child, which
/// lives no longer than the thread that called; `mesher` must take no lock that one of them may
/// hold (allocation is safe in glibc). Whatever the mesher prints is dropped. safety_limit_s: CPU
/// time of the child, against endless loops; a child that sleeps is killed after 20 times that.
std::variant<TetMesh, std::string> run_in_child(const std::function<TetMesh()>& mesher,
                                                const std::function<std::string(int)>& thrown_int,
                                                double safety_limit_s);

}  // namespace palpate
