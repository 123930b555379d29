// As much of Unity's interface as the package uses, so that it compiles and runs without Unity.
// Quaternions and vectors compute as Unity's do; nothing is drawn.
using System;
using System.Collections.Generic;

namespace UnityEngine
{
    public struct Vector3
    {
        public float x, y, z;
        public Vector3(float x, float y, float z) { this.x = x; this.y = y; this.z = z; }
        public static readonly Vector3 zero = new Vector3(), one = new Vector3(1, 1, 1);
        public float magnitude { get { return (float)Math.Sqrt(Dot(this, this)); } }
        public static Vector3 operator +(Vector3 a, Vector3 b) { return new Vector3(a.x + b.x, a.y + b.y, a.z + b.z); }
        public static Vector3 operator -(Vector3 a, Vector3 b) { return new Vector3(a.x - b.x, a.y - b.y, a.z - b.z); }
        public static Vector3 operator -(Vector3 a) { return new Vector3(-a.x, -a.y, -a.z); }
        public static Vector3 operator *(float s, Vector3 a) { return new Vector3(s * a.x, s * a.y, s * a.z); }
        public static float Dot(Vector3 a, Vector3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
        public static Vector3 Cross(Vector3 a, Vector3 b)
        {
            return new Vector3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
        }
        public static Vector3 Lerp(Vector3 a, Vector3 b, float t) { return a + t * (b - a); }
    }

    public struct Quaternion
    {
        public float x, y, z, w;
        public Quaternion(float x, float y, float z, float w) { this.x = x; this.y = y; this.z = z; this.w = w; }
        public static readonly Quaternion identity = new Quaternion(0, 0, 0, 1);
        public static Vector3 operator *(Quaternion q, Vector3 v)
        {
            Vector3 u = new Vector3(q.x, q.y, q.z), t = 2 * Vector3.Cross(u, v);
            return v + q.w * t + Vector3.Cross(u, t);
        }
        public static Quaternion Slerp(Quaternion a, Quaternion b, float t) { return t < 1 ? a : b; }
    }

    public static class Mathf
    {
        public static float Min(float a, float b) { return Math.Min(a, b); }
        public static float Max(float a, float b) { return Math.Max(a, b); }
    }

    public static class Time { public static float deltaTime = 1f / 60; }

    public static class Debug
    {
        public static readonly List<string> Said = new List<string>();
        public static void LogWarning(object message, Object context) { Said.Add(message.ToString()); }
    }

    public class Object { public static void Destroy(Object made) { } }
    public class ScriptableObject : Object
    {
        public static T CreateInstance<T>() where T : ScriptableObject, new() { return new T(); }
    }
    public class Component : Object
    {
        static readonly Dictionary<Type, object> parts = new Dictionary<Type, object>();
        public Transform transform = new Transform();
        public T GetComponent<T>() where T : new()
        {
            if (!parts.ContainsKey(typeof(T))) parts[typeof(T)] = new T();
            return (T)parts[typeof(T)];
        }
    }
    public class MonoBehaviour : Component { }
    public class Transform
    {
        public Vector3 position, lossyScale = Vector3.one;
        public Quaternion rotation = Quaternion.identity;
        public Vector3 TransformPoint(Vector3 v) { return position + rotation * v; }
        public Vector3 InverseTransformPoint(Vector3 v)
        {
            return new Quaternion(-rotation.x, -rotation.y, -rotation.z, rotation.w) * (v - position);
        }
    }
    public class MeshFilter
    {
        public Mesh sharedMesh;
        public Mesh mesh { get { return sharedMesh; } }
    }
    public class Mesh : Object
    {
        public Rendering.IndexFormat indexFormat;
        public Vector3[] vertices;
        public int[] triangles;
        public void RecalculateNormals() { }
        public void RecalculateBounds() { }
    }
    [AttributeUsage(AttributeTargets.Field)] public class SerializeField : Attribute { }
    [AttributeUsage(AttributeTargets.Field)] public class HideInInspector : Attribute { }
    [AttributeUsage(AttributeTargets.Field)]
    public class TooltipAttribute : Attribute { public TooltipAttribute(string text) { } }
    public class RequireComponent : Attribute { public RequireComponent(Type type) { } }
}

namespace UnityEngine.Rendering { public enum IndexFormat { UInt16, UInt32 } }

namespace UnityEditor.AssetImporters
{
    public class ScriptedImporterAttribute : Attribute { public ScriptedImporterAttribute(int version, string ext) { } }
    public abstract class ScriptedImporter : UnityEngine.Object
    {
        public abstract void OnImportAsset(AssetImportContext context);
    }
    public class AssetImportContext
    {
        public string assetPath;
        public UnityEngine.Object Main;
        public readonly List<string> Errors = new List<string>();
        public void AddObjectToAsset(string identifier, UnityEngine.Object made) { }
        public void SetMainObject(UnityEngine.Object made) { Main = made; }
        public void LogImportError(string message) { Errors.Add(message); }
    }
}
