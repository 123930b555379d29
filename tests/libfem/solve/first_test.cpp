#include <gtest/gtest.h>
#include <ctime>
#include <cstdio>
#include "libfem/solve/equilibrium.hpp"
#include "test_meshes.hpp"
using namespace palpate; using namespace palpate::fem;
static double cpu(){timespec t;clock_gettime(CLOCK_THREAD_CPUTIME_ID,&t);return t.tv_sec+1e-9*t.tv_nsec;}
TEST(First, press){
  const double S=1e-3; int n=atoi(getenv("N")?getenv("N"):"8"); double nu=atof(getenv("NU")?getenv("NU"):"0.45");
  double fine=atof(getenv("G")?getenv("G"):"4");
  auto stretch=[&](double t){ double s=2*t-1; return 60*std::sinh(fine*s)/std::sinh(fine);};
  auto map=[&](const Vec3&p){ double z=1-p.z(); double g=fine*0.7; return Vec3(stretch(p.x())*S,stretch(p.y())*S,-40*S*std::sinh(g*z)/std::sinh(g)); };
  TetMesh tm=grid_tets(n,n,n/2,map);
  QuadraticMesh q=quadratic(tm,[&](const Vec3&p){return p.z()<-39.999*S;});
  auto mat=make_material({"neo-hookean",{10e3,nu}},"t");
  double t0=cpu();
  EquilibriumOptions o; o.residual=atof(getenv("TOL")?getenv("TOL"):"1e-3");o.linear=atof(getenv("LIN")?getenv("LIN"):"0.05");o.most_pcg=atoi(getenv("PCG")?getenv("PCG"):"12");
  Equilibrium eq(q,{mat},nullptr,make_probe("sphere",10*S,0,"t"),{},o);
  printf("nodes %ld unknowns %d flops %.2f GF setup %.3f\n",(long)q.nodes.rows(),eq.unknowns(),eq.factor().factor_flops()/1e9,cpu()-t0);
  ProbePose pose{Vec3(0,0,0),-Vec3::UnitZ()};
  BodyState a=eq.rest(pose),b,prev=a; double dprev=0;
  t0=cpu();
  for(int k=1;k<=10;++k){ double d=k*S; pose.tip=Vec3(0,0,-d);
    Points guess = k>1? Points(a.u+(a.u-prev.u)) : a.u;
    auto st=eq.solve(a,pose,guess,b); (void)dprev;
    auto c=eq.counts();
    printf("d %2d st %d F %.6f pen %.4f mm area %.2f pts %d res %.1e J %.3f newton %d pcg %d model %d fac %d(%d) ls %d cpu %.3f reac %.6f\n",k,(int)st,b.contact.force_N.z(),b.contact.greatest_penetration_m*1e3,b.contact.area_m2*1e6,b.contact.points,b.relative_residual,b.least_J,c.newton,c.pcg,c.model,c.factorizations,c.failed_factorizations,c.backtracks,cpu()-t0,eq.reaction_N(b.u).z());
    if(st!=SolveStatus::solved) break;
    prev=a;a=b;
  }
}
