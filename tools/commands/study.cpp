#include <filesystem>
#include <nlohmann/json.hpp>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/study/schedule.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kListed = 15;

constexpr NamedOutput kFiles[] = {{"study.json", "{\"schema\":\"palpate-study\""},
                                  {"cost.json", "{\"prepare_s\":"},
                                  {"results.csv", "case,state,solved_from"},
                                  {"results.h5", "palpate-study"}};

class StudyCommand final : public Command {
 public:
  explicit StudyCommand(Arguments& arguments) {
    arguments.positionals("study", words_,
                          "Study to plan and run, STUDY.toml; or status DIR: how far it is; or "
                          "resume DIR: run only what is missing");
    arguments.option("-o,--output DIR", folder_, "Folder for all files of the study");
    arguments.named_outputs(folder_, kFiles);
    arguments.option("--on WHERE", on_,
                     "Where it runs: local (this process; the default), slurm (submits arrays), or "
                     "script (prints what any other scheduler would run)");
    arguments.option("--jobs", jobs_,
                     "Number of threads here; 0 uses all cores; results do not depend on it");
  }

  int run(Reply& reply) override {
    if (!on_.empty() && on_ != "local" && on_ != "slurm" && on_ != "script")
      throw Error("--on", fmt::format("\"{}\" is not known", on_), "Use local, slurm or script.");
    const std::string& what = words_.front();
    if (words_.size() == 2 && what == "status") return status(StudyFolder(words_[1]), reply);
    if (words_.size() == 2 && what == "resume") return resume(reply);
    if (words_.size() == 2 && what == "next") return submit(StudyFolder(words_[1]), true), kDone;
    if (words_.size() == 4 && what == "task") {
      const int failed = do_task(StudyFolder(words_[1]), words_[2], std::atoi(words_[3].c_str()),
                                 jobs_ > 0 ? jobs_ : 1);
      return failed ? kSomeFailed : kDone;
    }
    if (words_.size() != 1)
      throw Error(listed(words_, " "), "is neither a study nor something to do with one",
                  "Give STUDY.toml -o DIR, or status DIR, or resume DIR.");
    if (folder_.empty()) throw Error("-o", "is missing", "Name a folder for the study's files.");
    const Study study = read_study(what);
    StudyFolder::plan(folder_, study);
    std::size_t solved = 0;
    for (std::size_t i = 0; i < study.cases.size(); ++i)
      solved += study.cases[i].source == static_cast<int>(i);
    say("{} cases; {} are simulated, the others are these with forces times a factor",
        study.cases.size(), solved);
    return start(on_.empty() ? "local" : on_, reply);
  }

 private:
  int resume(Reply& reply) {
    folder_ = words_[1];
    const StudyFolder study(folder_);
    study.forget_failures();
    return start(!on_.empty() ? on_ : was_submitted(study) ? "slurm" : "local", reply);
  }

  int start(const std::string& on, Reply& reply) {
    StudyFolder study(folder_);
    if (on == "local") {
      do_all(study, jobs_);
      return status(study, reply);
    }
    study.measure();
    if (on == "slurm") {
      const int tasks = submit(study);
      say("{} tasks submitted; `palpate study status {}` says how far they are", tasks, folder_);
      reply.json = nlohmann::ordered_json{{"tasks", tasks}};
    } else {
      reply.text = script_of(study);
      reply.json = nlohmann::ordered_json{{"cases", study.cases().size()}, {"script", reply.text}};
    }
    return kDone;
  }

  int status(const StudyFolder& study, Reply& reply) {
    study.write_results();
    std::array<int, kCaseStateNames.size()> count{};
    std::size_t listed_failures = 0;
    const auto cases = static_cast<int>(study.cases().size());
    for (int i = 0; i < cases; ++i) {
      ++count[static_cast<std::size_t>(study.state(i))];
      if (const std::string failure = study.failure(i);
          !failure.empty() && ++listed_failures <= kListed)
        say_failed("case {} ({}): {}", i + 1,
                   listed(study.cases()[static_cast<std::size_t>(i)].inputs), failure);
    }
    double left_s = 0;
    for (std::size_t kind = 0; kind < kWorkNames.size(); ++kind)
      for (const Work& work : study.missing(static_cast<WorkKind>(kind)))
        left_s += study.expected_s(work);
    const SlurmQueue queue = queue_of(study);
    reply.json = nlohmann::ordered_json{{"cases", cases}};
    std::string states;
    for (std::size_t state = 0; state < count.size(); ++state) {
      reply.json[std::string(kCaseStateNames[state])] = count[state];
      if (count[state] > 0)
        states += fmt::format("{}{} {}", states.empty() ? "" : ", ", count[state],
                              kCaseStateNames[state]);
    }
    reply.text = fmt::format("{} cases: {}; {} lists them", cases, states,
                             (study.path() / "results.csv").string());
    const bool is_known = study.cost().point_s > 0;
    if (left_s > 0 && is_known)
      reply.text += fmt::format("\nleft: {} of one processor", in_words(left_s));
    if (was_submitted(study)) {
      reply.text +=
          fmt::format("\nslurm: {} tasks running, {} waiting", queue.running, queue.pending);
      if (queue.running > 0 && left_s > 0)
        reply.text += fmt::format("; about {} at this rate", in_words(left_s / queue.running));
      reply.json["running"] = queue.running;
      reply.json["queued"] = queue.pending;
    }
    if (count[0] < cases && queue.running + queue.pending == 0)
      reply.text +=
          fmt::format("\n`palpate study resume {}` runs what is missing", study.path().string());
    if (is_known) reply.json["left_cpu_s"] = left_s;
    return count[static_cast<std::size_t>(CaseState::failed)] ? kSomeFailed : kDone;
  }

  std::vector<std::string> words_;
  std::string folder_, on_;
  int jobs_ = 0;
};

}  // namespace

std::unique_ptr<Command> declare_study(Arguments& arguments) {
  return std::make_unique<StudyCommand>(arguments);
}

}  // namespace palpate::tools
