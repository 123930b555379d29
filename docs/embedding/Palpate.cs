// Palpate for C# (Unity, .NET): declarations of palpate.h, ABI 1. MIT licence.
// The native library is palpate_engine (libpalpate_engine.so, palpate_engine.dll). Structures are
// blittable: no marshalling and no garbage in the force thread. Sizes, in this order, are checked
// against the header by the project's tests (check_csharp.c).
//
//   size palpate_asset 1280, palpate_contact 3072, palpate_pose 56, palpate_tool 112,
//   size palpate_input 160, palpate_output 360, palpate_info 168, palpate_mesh 96
using System;
using System.Runtime.InteropServices;

public static unsafe class Palpate
{
    const string Library = "palpate_engine";
    public const int Abi = 1;

    [StructLayout(LayoutKind.Sequential)] public struct Asset { public fixed ulong Storage[160]; }
    [StructLayout(LayoutKind.Sequential)] public struct Contact { public fixed ulong Storage[384]; }

    [StructLayout(LayoutKind.Sequential)]
    public struct Pose
    {
        public fixed double PositionM[3];
        public fixed double OrientationWxyz[4]; // unit quaternion
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Tool
    {
        public fixed double OffsetM[3];
        public double RadiusM, DampingNsM, DamperDepthM;
        public double LateralDampingNsM, MaxForceN, RampS;
        public fixed double Reserved[5];
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Input
    {
        public Pose Tool, Body;
        public double DtS;
        public int WantsTangent;
        public fixed int Reserved[9];
    }

    public enum State { Air = 0, Stick = 1, Slip = 2 }

    [StructLayout(LayoutKind.Sequential)]
    public struct Output
    {
        public fixed double ForceOnToolN[3];
        public fixed double TorqueOnToolNm[3];
        public fixed double ContactM[3];
        public fixed double Normal[3];
        public fixed double Weight[3];
        public double NormalM, LateralM, StoredJ, DissipatedJ, RefusedJ, DampedJ, DamperN;
        public fixed double StiffnessNM[9];
        public long RefusedTicks;
        public int Triangle, State;
        public uint Flags;
        public int Status;
        public fixed double DeflectionM[3];
        public fixed double ActsAtM[3];
        public double ApproachMS;
        public uint Events; // 1 touched, 2 released
        public fixed uint Reserved[7];
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Info
    {
        public int Vertices, Triangles;
        public double MaxStepM, ProbeRadiusM;
        public fixed double BoxMinM[3];
        public fixed double BoxMaxM[3];
        public double RangeM;
        public ulong Checksum;
        public byte* Law;
        public int HasGuard, HasShape;
        public fixed int Reserved[12];
        public byte* MetaJson;
        public ulong MetaBytes;
    }

    [DllImport(Library)] public static extern int palpate_abi();
    [DllImport(Library)] static extern int palpate_sizes_fit(int abi, uint* bytes);
    [DllImport(Library)] static extern IntPtr palpate_sentence(int status);
    // bytes: at a multiple of 64 (palpate_copy_aligned), unchanged while in use.
    [DllImport(Library)]
    public static extern int palpate_open(out Asset asset, void* bytes, ulong size);
    [DllImport(Library)] public static extern void palpate_close(ref Asset asset);
    [DllImport(Library)]
    public static extern void* palpate_copy_aligned(void* room, ulong roomBytes, void* bytes,
                                                    ulong size);
    [DllImport(Library)] public static extern int palpate_describe(in Asset asset, out Info info);
    [DllImport(Library)] public static extern int palpate_start(out Contact contact, in Tool tool);
    [DllImport(Library)] public static extern int palpate_release(ref Contact contact);
    [DllImport(Library)]
    public static extern int palpate_tick(in Asset asset, ref Contact contact, in Input input,
                                          out Output output);

    // For the thread that draws: contact is a copy; displacementM has three floats a vertex.
    [DllImport(Library)]
    public static extern int palpate_deform(in Asset asset, in Contact contact, int first, int count,
                                            float* displacementM);

    // 0 when the library has this file's structures; ask before anything else.
    public static int HeaderFits()
    {
        uint* bytes = stackalloc uint[8] { (uint)sizeof(Asset), (uint)sizeof(Contact),
            (uint)sizeof(Pose), (uint)sizeof(Tool), (uint)sizeof(Input), (uint)sizeof(Output),
            (uint)sizeof(Info), 96 };
        return palpate_sizes_fit(Abi, bytes);
    }

    public static string Sentence(int status) => Marshal.PtrToStringAnsi(palpate_sentence(status));
}

// Unity is left-handed with y up: swap y and z of positions on the way in and of forces on the way
// out; a quaternion (x, y, z, w) there is (w, -x, -z, -y) here.
