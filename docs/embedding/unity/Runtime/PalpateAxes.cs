// The one place where axes are converted. Unity is left-handed with y up, Palpate right-handed with
// z up: y and z are swapped, and what turns turns the other way. Both count in metres. MIT licence.
using UnityEngine;

public static unsafe class PalpateAxes
{
    public static void ToPalpate(Vector3 v, double* to)
    {
        to[0] = v.x;
        to[1] = v.z;
        to[2] = v.y;
    }
    public static void ToPalpate(Quaternion q, double* wxyz)
    {
        double x = q.x, y = q.y, z = q.z, w = q.w, length = System.Math.Sqrt(x * x + y * y + z * z + w * w);
        wxyz[0] = w / length;
        wxyz[1] = -x / length;
        wxyz[2] = -z / length;
        wxyz[3] = -y / length;
    }
    public static Vector3 ToUnity(double* v) { return new Vector3((float)v[0], (float)v[2], (float)v[1]); }
    public static Vector3 ToUnity(double x, double y, double z) { return new Vector3((float)x, (float)z, (float)y); }
    /// Torques, which a mirror turns round.
    public static Vector3 ToUnityTorque(double* v) { return -ToUnity(v); }
}
