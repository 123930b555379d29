// A .palp in a Unity project (Editor/PalpImporter.cs makes it). MIT licence.
using UnityEngine;

public sealed class PalpateAsset : ScriptableObject
{
    [SerializeField, HideInInspector] byte[] content;
    PalpateEngine engine;

    public byte[] Content
    {
        get { return content; }
        set
        {
            content = value;
            engine = null;
        }
    }
    /// Opened at the first call, some ms; shared by all bodies.
    public PalpateEngine Engine { get { return engine ?? (engine = new PalpateEngine(content)); } }
}
