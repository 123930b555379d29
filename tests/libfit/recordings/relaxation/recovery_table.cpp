#include <cstdio>
#include <cstdlib>
#include "libfit/recordings/batch/condition.hpp"
#include "libfit/recordings/relaxation/bed_response.hpp"
#include "libfit/recordings/relaxation/fit_relaxation.hpp"
#include "tests/libfit/recordings/relaxation/relaxing_presses.hpp"
using namespace palpate; using namespace palpate::recordings; using namespace palpate::testing_relaxation;
struct Case { const char* name; RelaxingBody body; std::vector<Way> ways; double dt; Sensor sensor; };
int main(int argc, char** argv) {
  const int seeds = argc > 1 ? atoi(argv[1]) : 5; const int only = argc > 2 ? atoi(argv[2]) : -1; const int exactly = argc>3?atoi(argv[3]):-1;
  auto rel=[](std::vector<double> g, std::vector<double> t){ Relaxation r; r.share=Eigen::Map<Eigen::VectorXd>(g.data(),g.size()); r.time_s=Eigen::Map<Eigen::VectorXd>(t.data(),t.size()); return r;};
  Way hold; hold.go(-1e-3,0); hold.go(3e-3,2); hold.go(3e-3,20); hold.go(-1e-3,2); hold.go(-1e-3,2);
  Way stairs; stairs.go(-1e-3,0); for(int i=0;i<4;i++){ stairs.go((i+1)*0.75e-3, i?0.3:0.7); stairs.go((i+1)*0.75e-3,5);} stairs.go(-1e-3,2); stairs.go(-1e-3,1);
  Way slow; slow.go(-1e-3,0); slow.go(3e-3,8); slow.go(-1e-3,8);
  Way fast; fast.go(-1e-3,0); fast.go(3e-3,0.8); fast.go(-1e-3,0.8);
  Way nodrift=hold;
  std::vector<Case> cases{
   {"hold, 1 branch",{rel({0.5},{3}),1},{hold},0.01,{0.01,0}},
   {"hold, 2 branches",{rel({0.6,0.4},{0.5,6}),1},{hold},0.01,{0.01,0}},
   {"hold, 3 branches",{rel({0.8,0.5,0.5},{0.15,1.2,9}),1},{hold},0.01,{0.01,0}},
   {"stairs, 2 branches",{rel({0.6,0.4},{0.3,4}),1},{stairs},0.01,{0.01,0}},
   {"two rates, 1 branch",{rel({0.5},{1.0}),1},{slow,fast},0.01,{0.01,0}},
   {"hold, 1 branch, 1/f",{rel({0.5},{3}),1},{hold},0.01,{0.01,0.01}},
   {"hold, 2 branches, 1/f",{rel({0.6,0.4},{0.5,6}),1},{hold},0.01,{0.01,0.01}},
   {"hold, none",{rel({},{}),1},{hold},0.01,{0.01,0.01}},
  };
  for (std::size_t c=0;c<cases.size();++c){ if(only>=0&&(int)c!=only) continue; auto& k=cases[c];
    int right=0, psi[4]={0,0,0,0}; std::vector<int> in(6,0); double held[4]={0,0,0,0}; int hist[4]={0,0,0,0};
    double when[4]={0.1,0.5,2,8};
    std::vector<std::vector<double>> clean;
    for(int seed=0;seed<seeds;++seed){ std::mt19937 random(1000*c+seed);
      std::vector<RelaxingPress> presses;
      for(auto& w:k.ways){ auto raw=record(k.body,w,k.dt,3,k.sensor,random);
        SignalSettings s; s.radius_m=5e-3; s.tip=Tip::sphere; s.contact = "auto";
        Conditioned done=condition(raw,s,std::nullopt,"x.csv",false);
        presses.push_back({done.history,done.noise_N,done.contact_deviation_m});
        if(seeds<=3) printf("  rows %ld held %.2f contact %.1f +- %.1f um, noise %.4f of %.3f speed %g\n",(long)done.history.rows(),held_share(done.history),1e6*(done.contact_travel_m-1e-3),1e6*done.contact_deviation_m,done.noise_N,done.history.push_N.maxCoeff(),done.speed_m_s);
      }
      auto fit=fit_relaxation({presses},exactly);
      ++hist[fit.relaxation.branches()];
      Eigen::VectorXd at=Eigen::Map<Eigen::VectorXd>(when,4), truth=stiffening(k.body.relaxation,at); auto band=fit.band(at);
      for(int i=0;i<4;++i) psi[i]+= truth[i]>=band.low[i]&&truth[i]<=band.high[i];
      if(fit.relaxation.branches()==k.body.relaxation.branches()){ ++right; for(int b=0;b<fit.relaxation.branches();++b){ in[2*b]+=k.body.relaxation.share[b]>=fit.share_low[b]&&k.body.relaxation.share[b]<=fit.share_high[b]; in[2*b+1]+=k.body.relaxation.time_s[b]>=fit.time_low_s[b]&&k.body.relaxation.time_s[b]<=fit.time_high_s[b];}}
      if(seeds<=10){ printf("  seed %d K=%ld curve %d held",seed,(long)fit.relaxation.branches(),(int)fit.curve); for(double h:fit.held_out) printf(" %.4f",h); printf(" rms %.4f |",fit.rms_N); for(int b=0;b<fit.relaxation.branches();++b) printf(" g %.3f [%.3f %.3f] t %.3f [%.3f %.3f]",fit.relaxation.share[b],fit.share_low[b],fit.share_high[b],fit.relaxation.time_s[b],fit.time_low_s[b],fit.time_high_s[b]); printf(" psi(.5) %.3f [%.3f %.3f] true %.3f\n",band.middle[1],band.low[1],band.high[1],truth[1]); }
    }
    printf("%s: right K %d/%d (%d %d %d %d), g,t in:",k.name,right,seeds,hist[0],hist[1],hist[2],hist[3]); for(int b=0;b<2*k.body.relaxation.branches();++b) printf(" %d",in[b]); printf(" psi in: %d %d %d %d\n",psi[0],psi[1],psi[2],psi[3]); fflush(stdout);
  }
}
